#pragma once
#include <cmath>

#include "edge_line.h"
#include "furrow/geom/attitude.h"

/// What a camera sees of rows that are prisms along x (docs/formulation/altitude.md, sections 1, 2 and 5).
/// Templates, so that derivatives come from automatic differentiation.
namespace furrow::altitude {

/// Places in the pose block of a shot.
inline constexpr int kLogHeight = 0, kTheta = 1, kLambda = 2, kPsi = 3, kCrossTrack = 4, kPoseSize = 5;
/// Places in the farm block. Rounding and softness are logarithms of lengths over the half width: they have
/// no sign.
inline constexpr int kSpacing = 0, kHalfWidth = 1, kDepth = 2, kBaseRatio = 3, kRounding = 4, kSoftness = 5,
                     kFarmSize = 6;

template <class T>
struct Vector3 {
  T x, y, z;
};

/// m = cam_from_row e_y and q = cam_from_row e_z, with cam_from_row = cam_from_body (Rz(psi) Rx(lambda)
/// Ry(-theta))^T (eq. 1.2).
template <class T>
struct RowAxes {
  Vector3<T> m, q;
};

template <class T>
RowAxes<T> row_axes(const T& theta, const T& lambda, const T& psi) {
  using std::cos;
  using std::sin;
  const T ct = cos(theta), st = sin(theta), cl = cos(lambda), sl = sin(lambda), cp = cos(psi), sp = sin(psi);
  // Level vectors after Rx(-lambda) Rz(-psi), then Ry(theta), then forward-left-up to right-down-forward.
  const auto to_cam = [&](const T& x, const T& y, const T& z) {
    return Vector3<T>{-y, st * x - ct * z, ct * x + st * z};
  };
  return {to_cam(sp, cl * cp, -sl * cp), to_cam(T(0.0), sl, cl)};
}

/// Line on the unit plane of everything at slope t (lateral over drop): l = m + t q (eq. 2.2).
template <class T>
Vector3<T> line_at(const RowAxes<T>& axes, const T& t) {
  return {axes.m.x + t * axes.q.x, axes.m.y + t * axes.q.y, axes.m.z + t * axes.q.z};
}

/// Signed perpendicular distance of a point of the unit plane, drawn in by `zoom` (1 for the camera's own
/// focal length), from a line.
template <class T>
T distance(const Vector3<T>& l, const Eigen::Vector2d& p, const T& zoom = T(1.0)) {
  using std::sqrt;
  return ((l.x * p.x() + l.y * p.y()) / zoom + l.z) / sqrt(l.x * l.x + l.y * l.y);
}

template <class T>
T magnitude(const T& x) {
  return x < T(0.0) ? T(-x) : x;
}

/// Held to [0, 1]: w is the half width where the row is widest, so its base is no wider.
template <class T>
T share(const T& x) {
  return x < T(0.0) ? T(0.0) : x > T(1.0) ? T(1.0) : x;
}

/// An edge as it is seen: its slope, and the drop at which its line of sight touches the row.
template <class T>
struct Touch {
  T slope, drop;
};

/// The edges between which a row's green is seen.
template <class T>
struct VisibleRow {
  Touch<T> left, right;
};

/// Left edge of a rounded top whose axis lies at lateral y: half an ellipse of half width w, its highest
/// point at drop h, widest at h + r (eq. 5.1). The left edge seen from the right of it is the ellipse's
/// tangent; seen from its own side it is the widest point.
template <class T>
Touch<T> top_left(const T& y, const T& h, const T& w, const T& r) {
  using std::sqrt;
  const T widest = h + r;
  if (y + w <= T(0.0)) return {(y + w) / widest, widest};
  const T square = h * (h + 2.0 * r);  // widest^2 - r^2
  const T t = (y * widest + sqrt(r * r * y * y + w * w * square)) / square;
  return {t, widest - r * r * t / sqrt(w * w + r * r * t * t)};
}

/// How far the outline stands outside of that seen square to the rows, where the line of sight p slants along
/// them: leaves thin out towards the edge of a canopy, and a slanting line meets more of them (eq. 5.5).
template <class T>
T swell_at(const RowAxes<T>& axes, const T* farm, const Eigen::Vector2d& p) {
  using std::exp;
  using std::log;
  const T across = axes.m.x * p.x() + axes.m.y * p.y() + axes.m.z;
  const T down = axes.q.x * p.x() + axes.q.y * p.y() + axes.q.z;
  return magnitude(farm[kHalfWidth]) * exp(farm[kSoftness]) *
         (0.5 * log((p.squaredNorm() + 1.0) / (across * across + down * down)));
}

/// The cross-section of all rows: drop of the highest point, half width, depth of the rounded top, and half
/// width and drop of the base.
template <class T>
struct CrossSection {
  T h, w, r, base_w, base_h;
};

/// The cross-section outside of the farm's by `swell`.
template <class T>
CrossSection<T> cross_section(const T* pose, const T* farm, const T& swell) {
  using std::exp;
  // Lengths enter by their magnitudes: a prior that reaches 0 must not turn the row inside out.
  const T h = exp(pose[kLogHeight]), w = magnitude(farm[kHalfWidth]);
  // A solver's step may make leaves reach beyond the camera.
  const T s = swell < 0.5 * h ? swell : T(0.5 * h);
  return {h - s, w + s, w * exp(farm[kRounding]) + s, share(farm[kBaseRatio]) * w + s,
          h + magnitude(farm[kDepth])};
}

/// Eq. 5.1 to 5.3: left silhouette of a row at lateral y with a rounded top and a wall down to its base, and
/// what the neighbour nearer to the camera, one spacing to the left, leaves of it.
template <class T>
Touch<T> visible_left(const CrossSection<T>& c, const T& y, const T& spacing) {
  Touch<T> edge = top_left(y, c.h, c.w, c.r);
  const T base = (y + c.base_w) / c.base_h;
  if (base > edge.slope) edge = {base, c.base_h};
  const T beyond = -y - spacing;  // that neighbour's axis, mirrored: its right edge is the one that hides
  if (beyond + c.w <= T(0.0)) return edge;
  const Touch<T> front = top_left(beyond, c.h, c.w, c.r);
  return edge.slope > -front.slope ? Touch<T>{-front.slope, front.drop} : edge;
}

/// Lateral place of row k's axis.
template <class T>
T axis_of(const T* pose, const T* farm, int k) {
  return -pose[kCrossTrack] - static_cast<double>(k) * farm[kSpacing];
}

/// Row k, seen square to the rows.
template <class T>
VisibleRow<T> visible_row(const T* pose, const T* farm, int k) {
  const CrossSection<T> c = cross_section(pose, farm, T(0.0));
  const T y = axis_of(pose, farm, k);
  const Touch<T> mirrored = visible_left(c, T(-y), farm[kSpacing]);
  return {visible_left(c, y, farm[kSpacing]), {-mirrored.slope, mirrored.drop}};
}

/// Slope of an edge or of the middle of row k where its line of sight is p.
template <class T>
T slope_at(const RowAxes<T>& axes, const T* pose, const T* farm, int k, Side side, const Eigen::Vector2d& p) {
  const CrossSection<T> c = cross_section(pose, farm, swell_at(axes, farm, p));
  const T y = axis_of(pose, farm, k);
  const auto left = [&] { return visible_left(c, y, farm[kSpacing]).slope; };
  const auto right = [&] { return T(-visible_left(c, T(-y), farm[kSpacing]).slope); };
  if (side == Side::left) return left();
  return side == Side::right ? right() : T(0.5 * (left() + right()));
}

/// The camera's angles in the gimbal's order: yaw psi about the vertical, then roll lambda about the level
/// forward axis, then pitch theta about the camera's right axis. Regular at nadir, where geom::Attitude is
/// not; equal to it without roll.
struct GimbalAngles {
  double theta = 0.0, lambda = 0.0, psi = 0.0;
};

Eigen::Matrix3d cam_from_row(const GimbalAngles& angles);
/// The same orientation in the house's convention.
geom::Attitude attitude_from(const GimbalAngles& angles);
/// d(pitch, roll, yaw) / d(theta, lambda, psi).
Eigen::Matrix3d attitude_jacobian(const GimbalAngles& angles);
/// lambda of an attitude given as pitch and roll about the optical axis: the elevation of the camera's left
/// axis is the same in both.
double lambda_of(double pitch_rad, double roll_rad);

}  // namespace furrow::altitude
