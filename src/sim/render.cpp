#include <algorithm>
#include <cmath>
#include <Eigen/Geometry>
#include <memory>
#include <tuple>

#include "furrow/base/random.h"
#include "furrow/sim/world.h"
#include "sim/board.h"
#include "sim/canopy.h"
#include "sim/ground.h"
#include "sim/lens.h"
#include "sim/plan.h"
#include "sim/raster.h"

namespace furrow::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2f;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kNearest_m = 0.15;     // nothing nearer than that is drawn
constexpr double kPieceRadius_m = 1.3;  // of a piece of row about its middle, beyond its half width
constexpr double kAlong_px = 6.0;       // leaves may grow along the row up to this in the picture
constexpr double kAcross_px = 3.5;      // and across it
constexpr double kLobed_px = 9.0;       // half size in the picture from which a leaf shows its lobes
constexpr double kReach = 1.45;         // no corner of a leaf is farther from its middle, in half sizes
constexpr double kHexagon_px =
    2.5;  // half size from which a leaf is a hexagon; below, a rectangle of the same area
constexpr double kExact_px = 5.0;  // half size up to which one linear map serves a whole leaf
constexpr int kRollingNodes = 33;  // poses along a rolling-shutter picture
constexpr int kMostExposures = 8;  // pictures averaged for motion blur

struct Pose {
  Eigen::Matrix3d cam_from_plan;
  Vector3d centre;
};

/// The camera's pose over the rows of one picture.
class Poses {
 public:
  Poses(const FlightPath& path, double t_s, double readout_s, int height) {
    const int nodes = readout_s > 0.0 ? kRollingNodes : 1;
    for (int i = 0; i < nodes; ++i) {
      const double part = nodes > 1 ? static_cast<double>(i) / (nodes - 1) - 0.5 : 0.0;
      const CameraState state = path.at(t_s + part * readout_s);
      nodes_.push_back({state.cam_from_plan, state.centre_in_plan});
    }
    scale_ = nodes > 1 ? (nodes - 1.0) / (height - 1.0) : 0.0;
  }
  bool rolling() const { return nodes_.size() > 1; }
  const Pose& middle() const { return nodes_[nodes_.size() / 2]; }
  Pose at(double v) const {
    if (!rolling()) return nodes_.front();
    const double x = std::clamp(v * scale_, 0.0, static_cast<double>(nodes_.size()) - 1.000001);
    const auto i = static_cast<std::size_t>(x);
    const double w = x - static_cast<double>(i);
    // Neighbouring nodes differ by far less than a milliradian: the straight blend is a rotation to 1e-7.
    return {(1.0 - w) * nodes_[i].cam_from_plan + w * nodes_[i + 1].cam_from_plan,
            (1.0 - w) * nodes_[i].centre + w * nodes_[i + 1].centre};
  }

 private:
  std::vector<Pose> nodes_;
  double scale_ = 0.0;
};

}  // namespace

struct Renderer::Shared {
  explicit Shared(const Scene& s)
      : scene(s),
        path(s),
        terrain(s),
        rows(s.field.curvature_per_m),
        canopy(s),
        first_s(path.first_s() - s.field.before_m),
        last_s(path.last_s() + s.field.after_m),
        backdrop(scene, terrain, rows, canopy, first_s, last_s),
        rays(s.camera) {}

  LightImage expose(double t_s) const;
  int exposures(double t_s) const;

  const Scene scene;
  const FlightPath path;
  const Terrain terrain;
  const RowFrame rows;
  const Canopy canopy;
  const double first_s, last_s;
  const Backdrop backdrop;
  const RayTable rays;
};

namespace {

/// Draws the plants of one picture.
class Painter {
 public:
  Painter(const Scene& scene, const Terrain& terrain, const RowFrame& rows, const Canopy& canopy,
          const Poses& poses, const RayTable& rays, SampleBuffer& samples)
      : scene_(scene),
        terrain_(terrain),
        rows_(rows),
        canopy_(canopy),
        poses_(poses),
        rays_(rays),
        reach_(1.1 * std::max(rays.low().norm(), rays.high().norm())),
        samples_(samples) {
    colours_.push_back(Vector3f::Zero());
  }

  void paint(double first_s, double last_s) {
    const Field& f = scene_.field;
    std::vector<Piece> pieces;
    const int last = static_cast<int>(std::floor(last_s)) - 1;
    for (int row = -f.rows_each_side; row <= f.rows_each_side; ++row) {
      for (int number = static_cast<int>(std::ceil(first_s)); number <= last; ++number) {
        if (const auto piece = seen_piece(row, number)) pieces.push_back(*piece);
      }
    }
    // Near ones first: what they hide needs no light.
    std::sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) {
      return std::tie(a.distance_m, a.row, a.number) < std::tie(b.distance_m, b.row, b.number);
    });
    for (const Piece& piece : pieces) paint_piece(piece);
  }
  const std::vector<Vector3f>& colours() const { return colours_; }

 private:
  struct Piece {
    double distance_m;
    int row, number, level, hidden_side;
  };

  /// The piece, if it may be in the picture.
  std::optional<Piece> seen_piece(int row, int number) const {
    const Field& f = scene_.field;
    const double s = (number + 0.5) * Canopy::kPiece_m, l = row * f.spacing_m;
    const Vector2d xy = rows_.plan_from_row(s, l);
    const Vector3d middle(xy.x(), xy.y(), terrain_.height(xy.x(), xy.y()) + 0.6 * f.row_height_m);
    const Pose& pose = poses_.middle();
    const Vector3d away = middle - pose.centre;
    const int level = level_of(away, rows_.direction(s));
    const double radius = 0.5 * Canopy::kPiece_m + 0.6 * f.row_height_m + f.half_width_m +
                          0.5 * f.leaf_m * Canopy::stretch_of(level);
    if (!may_be_seen(pose.cam_from_plan * away, radius)) return std::nullopt;
    // Well to the side of a row, the far wall is behind the row's own leaves.
    const double aside = rows_.row_from_plan(pose.centre.x(), pose.centre.y()).y() - l;
    const int hidden = level > 0 && std::abs(aside) > 2.0 * f.half_width_m ? (aside > 0.0 ? -1 : 1) : 0;
    return Piece{away.norm(), row, number, level, hidden};
  }

  void paint_piece(const Piece& piece) {
    const double direction = rows_.direction((piece.number + 0.5) * Canopy::kPiece_m);
    leaves_.clear();
    const Course course =
        canopy_.append_piece(piece.row, piece.number, piece.level, direction, piece.hidden_side, leaves_);
    const Eigen::Matrix2d turn = Eigen::Rotation2Dd(direction).toRotationMatrix();
    for (const Leaf& leaf : leaves_) paint_leaf(leaf, course, turn);
  }

  /// Whether a ball reaches into the pyramid of the picture.
  bool may_be_seen(const Vector3d& in_cam, double radius) const {
    if (in_cam.z() < -radius) return false;
    const auto beyond = [&](double x, double limit) {
      return x - limit * in_cam.z() > radius * std::hypot(1.0, limit);
    };
    return !beyond(in_cam.x(), rays_.high().x()) && !beyond(-in_cam.x(), -rays_.low().x()) &&
           !beyond(in_cam.y(), rays_.high().y()) && !beyond(-in_cam.y(), -rays_.low().y());
  }

  int level_of(const Vector3d& away, double direction) const {
    const double distance = std::max(away.norm(), 0.1);
    const Vector3d along(std::cos(direction), std::sin(direction), 0.0);
    const double px_per_m = scene_.camera.fx / distance;
    // Seen from its nearest point a piece shows more of its length; half a metre nearer is the worst of a 1 m
    // piece.
    const double sine = std::min(1.0, away.cross(along).norm() / distance + 0.5 / distance);
    const double leaf_px = scene_.field.leaf_m * px_per_m;
    int longer = 0, wider = 0;
    const auto step = [](int i) { return static_cast<std::size_t>(i) + 1; };
    while (longer + 1 < Canopy::kStretches && Canopy::kStretch[step(longer)] * leaf_px * sine <= kAlong_px) {
      ++longer;
    }
    while (wider + 1 < Canopy::kWidenings && Canopy::kWiden[step(wider)] * leaf_px <= kAcross_px) ++wider;
    return longer + Canopy::kStretches * wider;
  }

  Vector3d in_plan(const Vector3f& row_offset, const Eigen::Matrix2d& turn) const {
    const Vector2d level = turn * Vector2d(row_offset.x(), row_offset.y());
    return {level.x(), level.y(), static_cast<double>(row_offset.z())};
  }

  std::optional<Vector2f> project(const Vector3d& x_in_cam) const {
    if (x_in_cam.z() < kNearest_m) return std::nullopt;
    const double limit = reach_ * x_in_cam.z();
    if (x_in_cam.head<2>().squaredNorm() > limit * limit) return std::nullopt;
    const auto px = camera::project(scene_.camera, x_in_cam);
    if (!px) return std::nullopt;
    return px->cast<float>();
  }

  void paint_leaf(const Leaf& leaf, const Course& course, const Eigen::Matrix2d& turn) {
    const Vector2d xy =
        rows_.plan_from_row(static_cast<double>(leaf.centre.x()), static_cast<double>(leaf.centre.y()));
    const Vector3d centre(xy.x(), xy.y(),
                          terrain_.height(xy.x(), xy.y()) + static_cast<double>(leaf.centre.z()));
    Pose rolled;
    const Pose* pose = &poses_.middle();
    Vector3d at = pose->cam_from_plan * (centre - pose->centre);
    std::optional<Vector2f> middle = project(at);
    if (!middle) return;
    for (int i = 0; poses_.rolling() && i < 2 && middle; ++i) {
      rolled = poses_.at(static_cast<double>(middle->y()));
      pose = &rolled;
      at = pose->cam_from_plan * (centre - pose->centre);
      middle = project(at);
    }
    if (!middle) return;
    const Vector3d along = pose->cam_from_plan * in_plan(leaf.along, turn);
    const Vector3d across = pose->cam_from_plan * in_plan(leaf.across, turn);
    const double half_px = scene_.camera.fx * std::max(along.norm(), across.norm()) / at.z();
    const auto width = static_cast<double>(samples_.width()), height = static_cast<double>(samples_.height());
    const auto mu = static_cast<double>(middle->x()), mv = static_cast<double>(middle->y());
    const double margin = kReach * half_px + 1.0;
    if (mu < -margin || mv < -margin || mu > width + margin || mv > height + margin) return;
    const auto nearness = static_cast<float>(1.0 / at.z());
    if (samples_.hides(*middle, static_cast<float>(kReach * half_px), nearness)) return;
    outline(leaf, half_px, at, along, across, *middle);
    const bool lobed = leaf.shape == Shape::leaf && half_px > kLobed_px;
    const auto next = static_cast<std::int32_t>(colours_.size());
    if (lobed) {
      for (std::size_t i = 0; i < corners_.size(); ++i) {
        const std::array<Vector2f, 3> lobe = {*middle, corners_[i], corners_[(i + 1) % corners_.size()]};
        samples_.fill(lobe, nearness, next + static_cast<std::int32_t>(i));
      }
    } else if (!samples_.fill(corners_, nearness, next)) {
      return;
    }
    add_colours(Backdrop::through_air(canopy_.light(leaf, course), at.norm()), lobed);
  }

  /// corners_ of a leaf in the picture.
  void outline(const Leaf& leaf, double half_px, const Vector3d& at, const Vector3d& along,
               const Vector3d& across, const Vector2f& middle) {
    static const auto kHexagon = hexagon_outline();
    static const auto kRectangle = rectangle_outline();
    static const auto kLobed = lobed_outline();
    const std::array<Vector2f, 4> blade = blade_outline(leaf.taper);
    std::span<const Vector2f> shape = blade;
    if (leaf.shape == Shape::leaf && half_px > kLobed_px) {
      shape = kLobed;
    } else if (leaf.shape == Shape::leaf) {
      shape = kRectangle;
      if (half_px > kHexagon_px) shape = kHexagon;
    }
    corners_.clear();
    if (half_px <= kExact_px) {
      const double scale_u = scene_.camera.fx / at.z(), scale_v = scene_.camera.fy / at.z();
      const double x = at.x() / at.z(), y = at.y() / at.z();
      const auto map = [&](const Vector3d& d) {
        return Vector2d(scale_u * (d.x() - x * d.z()), scale_v * (d.y() - y * d.z())).cast<float>().eval();
      };
      const Vector2f a = map(along), b = map(across);
      for (const Vector2f& corner : shape) corners_.push_back(middle + corner.x() * a + corner.y() * b);
      return;
    }
    for (const Vector2f& corner : shape) {
      const auto px =
          project(at + static_cast<double>(corner.x()) * along + static_cast<double>(corner.y()) * across);
      corners_.push_back(px.value_or(middle));
    }
  }

  /// The colour of the surface just drawn; of a lobed leaf, folded a little along its midrib, one for each
  /// lobe.
  void add_colours(const Vector3f& colour, bool lobed) {
    if (!lobed) {
      colours_.push_back(colour);
      return;
    }
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      const float half = i < corners_.size() / 2 ? 1.10F : 0.90F;
      colours_.push_back(colour * half * (i % 2 == 0 ? 1.04F : 0.96F));
    }
  }

  const Scene& scene_;
  const Terrain& terrain_;
  const RowFrame& rows_;
  const Canopy& canopy_;
  const Poses& poses_;
  const RayTable& rays_;
  const double reach_;  // no ray of the picture lies farther from the axis, on the plane z = 1
  SampleBuffer& samples_;
  std::vector<Vector3f> colours_;
  std::vector<Leaf> leaves_;
  std::vector<Vector2f> corners_;
};

}  // namespace

LightImage Renderer::Shared::expose(double t_s) const {
  const int width = scene.camera.width, height = scene.camera.height;
  const Poses poses(path, t_s, scene.pictures.readout_time_s, height);
  SampleBuffer samples(width, height);
  Painter painter(scene, terrain, rows, canopy, poses, rays, samples);
  painter.paint(first_s, last_s);
  const std::vector<Vector3f>& colours = painter.colours();
  LightImage light(width, height);
  const double pixel_angle = 1.0 / scene.camera.fx;
  std::size_t pixel = 0;
  for (int v = 0; v < height; ++v) {
    const Pose pose = poses.at(v);
    const Eigen::Matrix3d plan_from_cam = pose.cam_from_plan.transpose();
    for (int u = 0; u < width; ++u, ++pixel) {
      const SampleBuffer::Int4 surface = samples.surface(pixel);
      const SampleBuffer::Float4 nearness = samples.nearness(pixel);
      const bool covered = surface[0] != 0 && surface[1] != 0 && surface[2] != 0 && surface[3] != 0;
      // On flat land nothing of the ground stands before the plants.
      Backdrop::Hit behind;
      if (!covered || !terrain.flat()) {
        const Vector2d& ray = rays.pixel(u, v);
        behind = backdrop.look(pose.centre, plan_from_cam * Vector3d(ray.x(), ray.y(), 1.0), pixel_angle);
      }
      Vector3f sum = Vector3f::Zero();
      for (int i = 0; i < kSamplesPerPixel; ++i) {
        const bool plant = surface[i] != 0 && nearness[i] > behind.inverse_depth * 0.998F;
        sum += plant ? colours[static_cast<std::size_t>(surface[i])] : behind.colour;
      }
      light.data[pixel] = sum / static_cast<float>(kSamplesPerPixel);
    }
  }
  return light;
}

int Renderer::Shared::exposures(double t_s) const {
  const double open_s = scene.pictures.exposure_time_s;
  if (open_s <= 0.0) return 1;
  const CameraState a = path.at(t_s - 0.5 * open_s), b = path.at(t_s + 0.5 * open_s);
  const double nearest_m = std::max(0.5, a.height_above_ground_m - scene.field.row_height_m);
  const double turned = Eigen::AngleAxisd(b.cam_from_plan * a.cam_from_plan.transpose()).angle();
  const double moved_px =
      scene.camera.fx * ((b.centre_in_plan - a.centre_in_plan).norm() / nearest_m + turned);
  return std::clamp(static_cast<int>(std::lround(moved_px)), 1, kMostExposures);
}

Renderer::Renderer(const Scene& scene) : shared_(std::make_unique<Shared>(scene)) {}
Renderer::~Renderer() = default;

Image Renderer::shot(std::size_t index) const {
  check(index < shared_->path.shot_times().size(), "a shot of the scene");
  const double t_s = shared_->path.shot_times()[index];
  const int exposures = shared_->exposures(t_s);
  LightImage light(shared_->scene.camera.width, shared_->scene.camera.height);
  for (int i = 0; i < exposures; ++i) {
    const double part = (i + 0.5) / exposures - 0.5;
    const LightImage one = shared_->expose(t_s + part * shared_->scene.pictures.exposure_time_s);
    for (std::size_t p = 0; p < one.data.size(); ++p)
      light.data[p] += one.data[p] / static_cast<float>(exposures);
  }
  const std::uint64_t key = base::mix_bits(shared_->scene.seed ^ base::mix_bits(0x9042 + index));
  return develop(std::move(light), shared_->scene.pictures, key);
}

Image Renderer::board(int index) const {
  check(index >= 0 && index < shared_->scene.boards.count, "a board picture of the scene");
  const Rigid3 cam_from_board = true_boards(shared_->scene)[static_cast<std::size_t>(index)];
  const std::uint64_t key =
      base::mix_bits(shared_->scene.seed ^ base::mix_bits(0xb0a4d + static_cast<std::uint64_t>(index)));
  return develop(light_board(shared_->scene, shared_->rays, cam_from_board, key), shared_->scene.pictures,
                 key);
}

}  // namespace furrow::sim
