#include <chrono>
#include <cmath>
#include <mutex>

#include "furrow/base/file.h"
#include "furrow/base/parallel.h"
#include "furrow/figures/figures.h"
#include "furrow/image/video.h"
#include "furrow/project/jobs.h"
#include "furrow/rows/thesis.h"

namespace furrow::project {
namespace {

namespace fs = std::filesystem;
using base::Array;
using base::Value;

/// Coordinates are kept to a thousandth of a pixel, far below any sigma.
double rounded(double value) {
  return std::round(value * 1000.0) / 1000.0;
}

Value point(double u, double v) {
  return Array{rounded(u), rounded(v)};
}

Value row_value(const rows::RowLine& row) {
  Value value;
  value.set("index", row.index);
  Array centre;
  Array left;
  Array right;
  for (const rows::RowSample& sample : row.samples) {
    centre.push_back(point(sample.centre_px.x(), sample.centre_px.y()));
    if (std::isfinite(sample.left_u_px)) left.push_back(point(sample.left_u_px, sample.centre_px.y()));
    if (std::isfinite(sample.right_u_px)) right.push_back(point(sample.right_u_px, sample.centre_px.y()));
  }
  value.set("points_px", std::move(centre));
  value.set("half_width_px", row.half_width_px ? Value(rounded(row.half_width_px->value)) : Value());
  value.set("half_width_sigma_px", row.half_width_px ? Value(rounded(row.half_width_px->sigma)) : Value());
  value.set("left_edge_px", std::move(left));
  value.set("right_edge_px", std::move(right));
  value.set("seen", row.seen);
  return value;
}

/// Names for the pictures' entries and files: the stem, with the folder in front where two are equal.
std::vector<std::string> names_of(const std::vector<fs::path>& images) {
  std::vector<std::string> names;
  names.reserve(images.size());
  for (const fs::path& file : images) names.push_back(file.stem().string());
  names = base::names_apart(std::move(names), images);
  for (std::string& name : names) name = fs::path(name).relative_path().string();
  return names;
}

RowsOfImage failed(const std::string& image, const std::string& method, Error error) {
  error.where = image;  // outputs hold no absolute path
  RowsOfImage result;
  result.image = image;
  result.lines.method = method;
  result.lines.status = error.code;
  result.lines.reason = error.message();
  return result;
}

Status write_overlay(const fs::path& folder, const std::string& name, const Image& picture,
                     const rows::RowLines& lines) {
  FURROW_TRY(figures::Figure figure, figures::row_overlay(picture, lines, name));
  return base::write_file(folder / (name + ".png"), figure.png);
}

Status write_steps(const fs::path& folder, const std::string& name, const Image& picture) {
  for (const auto& step : rows::thesis_steps(picture)) {
    FURROW_DO(image::write_image(folder / (name + "_" + step.name + ".png"), step.picture));
  }
  return Done{};
}

Result<RowsOfImage> process(const fs::path& file, const std::string& name, const fs::path& out,
                            const RowsJobOptions& options) {
  const std::string image = name + file.extension().string();
  const auto picture = image::read_image(file);
  if (!picture.ok()) {
    return failed(image, options.detect.method == rows::Method::thesis ? "thesis" : "field", picture.error());
  }
  RowsOfImage result;
  result.image = image;
  const auto start = std::chrono::steady_clock::now();
  result.lines = rows::detect(*picture, options.detect);
  result.elapsed_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  if (options.overlays) FURROW_DO(write_overlay(out / "overlays", name, *picture, result.lines));
  if (options.steps) FURROW_DO(write_steps(*options.steps, name, *picture));
  return result;
}

}  // namespace

Value rows_document(const std::vector<RowsOfImage>& images) {
  Array entries;
  for (const RowsOfImage& one : images) {
    const rows::RowLines& lines = one.lines;
    Value value;
    value.set("image", one.image);
    value.set("size", Array{lines.width, lines.height});
    value.set("method", lines.method);
    value.set("status", lines.status);
    value.set("reason", lines.reason);
    value.set("confidence", rounded(lines.confidence));
    value.set("vanishing_point_px", lines.vanishing_point_px
                                        ? point(lines.vanishing_point_px->x(), lines.vanishing_point_px->y())
                                        : Value());
    Array row_values;
    for (const rows::RowLine& row : lines.rows) row_values.push_back(row_value(row));
    value.set("rows", std::move(row_values));
    value.set("elapsed_ms", rounded(one.elapsed_ms));
    entries.push_back(std::move(value));
  }
  Value document;
  document.set("images", std::move(entries));
  return document;
}

Result<std::vector<RowsOfImage>> rows_job(const std::vector<fs::path>& named, const fs::path& out,
                                          const RowsJobOptions& options, const JobOptions& job) {
  FURROW_TRY(const auto images, image::picture_files(named));
  const std::vector<std::string> names = names_of(images);
  std::vector<RowsOfImage> results(images.size());
  std::optional<Error> failure;
  std::mutex mutex;
  std::size_t done = 0;
  base::parallel_for(images.size(), job.threads, [&](std::size_t i) {
    auto result = process(images[i], names[i], out, options);
    const std::lock_guard lock(mutex);
    if (result.ok()) {
      results[i] = std::move(*result);
    } else if (!failure) {
      failure = result.error();
    }
    base::report(job.progress, "finding rows", ++done, images.size());
  });
  if (failure) return *failure;
  FURROW_DO(base::write_file(out / "rows.json", base::to_json(rows_document(results)) + "\n"));
  return results;
}

}  // namespace furrow::project
