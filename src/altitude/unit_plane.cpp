#include "furrow/altitude/unit_plane.h"

#include <algorithm>
#include <cmath>

namespace furrow::altitude {
namespace {

/// Sigma taken when the detection states none: a row's middle is rarely found better than to a pixel.
constexpr double kUnstatedSigmaPx = 1.0;

/// Finest sigma believed: leaves end within a pixel or two, whatever a fit to many of them says. It keeps
/// cuts near the horizon, where a row is a few pixels wide, from outweighing all others.
constexpr double kFinestSigmaPx = 1.0;

double stated_or_default(double sigma_px) {
  return std::isfinite(sigma_px) && sigma_px > 0.0 ? std::max(sigma_px, kFinestSigmaPx) : kUnstatedSigmaPx;
}

std::optional<Eigen::Vector2d> edge_on_unit_plane(const Camera& camera, double u, double v) {
  if (!std::isfinite(u)) return std::nullopt;
  return camera::unproject(camera, {u, v});
}

/// Normal, on the unit plane, of the row where it passes this sample: from the neighbours' centres.
Eigen::Vector2d normal_at(const std::vector<RowDirection>& directions, std::size_t i) {
  const std::size_t before = i > 0 ? i - 1 : i;
  const std::size_t after = i + 1 < directions.size() ? i + 1 : i;
  const Eigen::Vector2d along = directions[after].centre - directions[before].centre;
  const double length = along.norm();
  // A single sample has no direction: taken as upright in the picture, so that its normal is along u.
  if (!(length > 0.0)) return Eigen::Vector2d::UnitX();
  return {along.y() / length, -along.x() / length};
}

/// Takes sigmas from pixels to the unit plane, across the row. A sample's sigma is stated across the row in
/// the picture; an edge's along the picture row (docs/formulation/altitude.md, section 4).
void scale_sigmas(const Camera& camera, RowsOnUnitPlane::Row& row) {
  for (std::size_t i = 0; i < row.directions.size(); ++i) {
    RowDirection& d = row.directions[i];
    const auto jacobian = camera::unproject_jacobian(camera, d.centre);
    const Eigen::Matrix2d unit_from_px =
        jacobian ? *jacobian : Eigen::Vector2d(1.0 / camera.fx, 1.0 / camera.fy).asDiagonal().toDenseMatrix();
    const Eigen::RowVector2d across = normal_at(row.directions, i).transpose() * unit_from_px;
    d.sigma *= across.norm();
    d.edge_sigma *= std::abs(across.x());
    d.top_sigma *= std::abs(across.x());
  }
}

RowsOnUnitPlane::Row unproject_row(const rows::RowLine& line, const Camera& camera) {
  RowsOnUnitPlane::Row row;
  row.index = line.index;
  for (const rows::RowSample& sample : line.samples) {
    if (!sample.centre_px.allFinite()) continue;
    const auto centre = camera::unproject(camera, sample.centre_px);
    if (!centre) continue;
    RowDirection d;
    d.centre = *centre;
    d.sigma = stated_or_default(sample.sigma_px);
    d.left = edge_on_unit_plane(camera, sample.left_u_px, sample.centre_px.y());
    d.right = edge_on_unit_plane(camera, sample.right_u_px, sample.centre_px.y());
    d.edge_sigma = stated_or_default(sample.edge_sigma_px);
    d.top_left = edge_on_unit_plane(camera, sample.top_left_u_px, sample.centre_px.y());
    d.top_right = edge_on_unit_plane(camera, sample.top_right_u_px, sample.centre_px.y());
    d.top_sigma = stated_or_default(sample.top_sigma_px);
    row.directions.push_back(d);
  }
  scale_sigmas(camera, row);
  return row;
}

}  // namespace

Result<RowsOnUnitPlane> rows_on_unit_plane(const rows::RowLines& lines, const Camera& camera) {
  FURROW_DO(camera::validate(camera));
  if (!lines.ok()) {
    return Error{"rows_not_ok", "rows",
                 "status " + lines.status + (lines.reason.empty() ? "" : ": " + lines.reason),
                 "a picture in which rows were found", ""};
  }
  if (lines.width != camera.width || lines.height != camera.height) {
    return Error{"picture_size_differs", "rows",
                 "rows of a " + std::to_string(lines.width) + "x" + std::to_string(lines.height) + " picture",
                 "the camera's " + std::to_string(camera.width) + "x" + std::to_string(camera.height),
                 "carry the camera to the picture's size first"};
  }
  RowsOnUnitPlane result;
  for (const rows::RowLine& line : lines.rows) {
    RowsOnUnitPlane::Row row = unproject_row(line, camera);
    if (!row.directions.empty()) result.rows.push_back(std::move(row));
  }
  if (lines.vanishing_point_px && lines.vanishing_point_px->allFinite()) {
    result.vanishing_point = camera::unproject(camera, *lines.vanishing_point_px);
  }
  return result;
}

}  // namespace furrow::altitude
