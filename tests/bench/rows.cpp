// Accuracy and time of row detection on pictures with published truth.
//
//   bench_rows [--data DIR] [--half all|even|odd] [--method thesis|field|bound] [--list] [--draw DIR]
//              [--perturbed] [--sweep] [--times]
//
// CRBD: CRDA (Vidovic, Cupec, Hocenski 2016) with m = 3 adjacent rows and the best of seven shifts, one per
// picture; and the share of pictures whose median relative spacing error over the picture rows is below 5 %.
// CRDLD: the followed row lies within 5 % of the picture's width of the true centre row at 60 % and at 90 %
// of the height; the centre row is, for both, the one nearest the middle column at 75 % of the height.
// "bound" fits the planar field to the truth itself. Halves are by sorted name: even is for development, odd
// is held back from looks. --perturbed scores copies of the pictures too (mirrored, cropped, ...): a change
// that gains on the pictures alone is noise. --sweep shows where the method ends, on drawn fields. --times
// takes the CPU time of the thread at 320x240 and 1280x720, the least of three runs a picture.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <functional>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "bench/perturb.h"
#include "bench/rows_sweep.h"
#include "furrow/base/value.h"
#include "furrow/image/image.h"
#include "furrow/rows/detect.h"
#include "furrow/stats/robust.h"
#include "rows/simplex.h"

namespace fs = std::filesystem;
using namespace furrow;

namespace {

constexpr double kCrdaSigma = 0.1;  // tolerance of CRDA in spacings
constexpr int kCrdaShift = 3;       // shifts -3..3
constexpr double kSpacingTolerance = 0.05, kCentreTolerance = 0.05;

struct Arguments {
  fs::path data;
  std::string half = "all", method;
  bool list = false, perturbed = false, sweep = false, times = false;
  fs::path draw;
};

/// Truth of CRBD: row k of the crop lies at u = c + k d + 160 on picture row v.
struct CrbdTruth {
  int first_v = 0;
  std::vector<double> c, d;
  double u(std::size_t i, double k) const { return c[i] + k * d[i] + 160.0; }
  double v(std::size_t i) const { return first_v + static_cast<double>(i); }
};

CrbdTruth read_crp(const fs::path& file) {
  std::ifstream in(file);
  CrbdTruth truth;
  double c = 0.0, d = 0.0;
  while (in >> c >> d) {
    truth.c.push_back(c);
    truth.d.push_back(d);
  }
  truth.first_v = 240 - static_cast<int>(truth.c.size());
  return truth;
}

using RowPlace = std::function<std::optional<double>(int index, double v)>;

struct Crda {
  double value = 0.0;
  std::array<double, 4> by_quarter{};  // of the rows with truth, from the top
};

Crda crda(const CrbdTruth& truth, const RowPlace& place) {
  Crda best;
  const std::size_t count = truth.c.size();
  for (int shift = -kCrdaShift; shift <= kCrdaShift; ++shift) {
    Crda one;
    for (std::size_t i = 0; i < count; ++i) {
      for (int k = -1; k <= 1; ++k) {
        const auto u = place(k + shift, truth.v(i));
        if (!u) continue;
        const double off = (truth.u(i, k) - *u) / (kCrdaSigma * truth.d[i]);
        const double part = std::max(1.0 - off * off, 0.0) / (3.0 * static_cast<double>(count));
        one.value += part;
        one.by_quarter[4 * i / count] += 4.0 * part;
      }
    }
    if (one.value > best.value) best = one;
  }
  return best;
}

/// Median over picture rows of |d - d_true| / d_true, d from the row left and right of index 0 (or the one
/// that exists).
double spacing_error(const CrbdTruth& truth, const RowPlace& place) {
  std::vector<double> errors;
  for (std::size_t i = 0; i < truth.c.size(); ++i) {
    const auto left = place(-1, truth.v(i)), middle = place(0, truth.v(i)), right = place(1, truth.v(i));
    double d = 0.0;
    if (left && right) {
      d = 0.5 * (*right - *left);
    } else if (middle && right) {
      d = *right - *middle;
    } else if (left && middle) {
      d = *middle - *left;
    }
    errors.push_back(std::abs(d - truth.d[i]) / truth.d[i]);
  }
  return stats::median(errors);
}

/// Valid while `lines` is.
RowPlace place_in(const rows::RowLines& lines) {
  std::map<int, const rows::RowLine*> by_index;
  for (const rows::RowLine& row : lines.rows) by_index[row.index] = &row;
  return [by_index](int index, double v) -> std::optional<double> {
    const auto found = by_index.find(index);
    if (found == by_index.end()) return std::nullopt;
    return rows::u_at(*found->second, v);
  };
}

/// The planar field nearest to the truth: least soft error over rows -1, 0, 1, from bottom and top.
rows::PlanarField fit_to_truth(const CrbdTruth& truth, bool with_bend2) {
  const std::size_t last = truth.c.size() - 1;
  const auto field_of = [&](const std::array<double, 6>& x) {
    rows::PlanarField field;
    field.u0 = 159.5, field.v0 = 239.0, field.length = 240.0;
    field.convergence = x[0], field.spacing = x[1], field.offset = x[2], field.slope = x[3],
    field.bend = x[4], field.bend2 = x[5];
    return field;
  };
  const auto cost = [&](const std::array<double, 6>& x) {
    const auto field = field_of(x);
    double sum = 0.0;
    for (std::size_t i = 0; i < truth.c.size(); ++i) {
      if (field.scale(truth.v(i)) <= 0.0) {
        sum += 3.0;
        continue;
      }
      for (int k = -1; k <= 1; ++k) {
        const double off = (truth.u(i, k) - field.u_at(truth.v(i), k)) / (kCrdaSigma * truth.d[i]);
        sum += off * off / (1.0 + off * off);
      }
    }
    return sum;
  };
  std::array<double, 6> x{1.0 - truth.d[0] / truth.d[last], truth.d[last], truth.c[last],
                          truth.c[last] - truth.c[0],       0.0,           0.0};
  for (int round = 0; round < 12; ++round) {
    const double size = std::pow(0.7, round);
    x = rows::minimise_simplex(
        cost, x, {0.1 * size, 10.0 * size, 10.0 * size, 40.0 * size, 4.0 * size, with_bend2 ? size : 0.0},
        800, 1e-9);
  }
  return field_of(x);
}

struct Frame {
  std::string name;
  Image picture;
};

bool in_half(std::size_t position, const std::string& half) {
  return half == "all" || (half == "even") == (position % 2 == 0);
}

std::vector<fs::path> pictures_in(const fs::path& folder) {
  std::vector<fs::path> files;
  if (fs::exists(folder))
    for (const auto& entry : fs::directory_iterator(folder))
      if (entry.path().extension() == ".jpg") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

/// CPU time of this thread: what else runs on the machine does not count.
double thread_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

rows::RowLines timed_detect(const Image& picture, rows::Method method, double& ms) {
  rows::DetectOptions options;
  options.method = method;
  const double start = thread_ms();
  auto lines = rows::detect(picture, options);
  ms = thread_ms() - start;
  return lines;
}

void put(Image& canvas, double u, double v, const std::array<int, 3>& colour) {
  if (!std::isfinite(u)) return;
  const int x = static_cast<int>(std::lround(u)), y = static_cast<int>(std::lround(v));
  if (x < 0 || y < 0 || x >= canvas.width || y >= canvas.height) return;
  for (int i = 0; i < 3; ++i)
    canvas.at(x, y)[i] = static_cast<std::uint8_t>(colour[static_cast<std::size_t>(i)]);
}

Image overlay(const Image& picture, const rows::RowLines& lines) {
  Image canvas = picture;
  for (const rows::RowLine& row : lines.rows) {
    for (int v = 0; v < canvas.height; ++v) {
      const auto u = rows::u_at(row, v);
      if (!u) continue;
      for (int i = 0; i <= canvas.width / 640; ++i)
        put(canvas, *u + i, v, row.index == 0 ? std::array{255, 0, 0} : std::array{255, 255, 0});
    }
    for (const rows::RowSample& sample : row.samples) {
      for (int i = -1; i <= 1; ++i) {
        put(canvas, sample.left_u_px, sample.centre_px.y() + i, {0, 255, 255});
        put(canvas, sample.right_u_px, sample.centre_px.y() + i, {255, 0, 255});
      }
    }
  }
  return canvas;
}

struct Tally {
  std::vector<double> scores, spacing_errors, ms, confidences;
  std::array<std::vector<double>, 4> by_quarter;
  int right = 0;
  int sure = 0, sure_right = 0;  // confidence 0.9 and more
  std::vector<bench::Answer> answers;

  void count_confidence(double confidence, bool is_right) {
    answers.push_back({confidence, is_right});
    if (confidence < 0.9) return;
    ++sure;
    sure_right += is_right;
  }
};

/// How often pictures of some confidence were right.
void print_reliability(const std::string& method_name, const std::vector<bench::Answer>& answers) {
  constexpr std::array kBorders = {0.0, 0.2, 0.4, 0.6, 0.8, 0.9, 0.95, 0.99, 1.01};
  if (answers.empty()) return;
  std::printf("confidence %-6s", method_name.c_str());
  for (std::size_t i = 0; i + 1 < kBorders.size(); ++i) {
    int count = 0, right = 0;
    double sum = 0.0;
    for (const bench::Answer& answer : answers) {
      if (answer.confidence < kBorders[i] || answer.confidence >= kBorders[i + 1]) continue;
      ++count, right += answer.is_right, sum += answer.confidence;
    }
    if (count > 0) std::printf(" %.2f: %d of %d", sum / count, right, count);
  }
  std::printf("\n");
}

void print_line(const Arguments& arguments, const std::string& name, double score,
                const rows::RowLines& lines, double extra) {
  if (!arguments.list) return;
  std::printf("  %-22s score %.3f spacing_error %.3f rows %zu confidence %.2f %s\n", name.c_str(), score,
              extra, lines.rows.size(), lines.confidence, lines.status.c_str());
}

std::vector<bench::Answer> bench_crbd(const Arguments& arguments, rows::Method method,
                                      const std::string& method_name) {
  Tally tally;
  const auto files = pictures_in(arguments.data / "rows/crbd-train");
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (!in_half(i, arguments.half)) continue;
    const auto picture = image::read_image(files[i]);
    if (!picture.ok()) continue;
    const CrbdTruth truth = read_crp(fs::path(files[i]).replace_extension(".crp"));
    double ms = 0.0;
    const auto lines = timed_detect(*picture, method, ms);
    const Crda full_score = crda(truth, place_in(lines));
    const double score = full_score.value;
    const double error = spacing_error(truth, place_in(lines));
    tally.scores.push_back(score);
    for (std::size_t q = 0; q < 4; ++q) tally.by_quarter[q].push_back(full_score.by_quarter[q]);
    tally.spacing_errors.push_back(error);
    tally.ms.push_back(ms);
    if (error < kSpacingTolerance) ++tally.right;
    tally.count_confidence(lines.confidence, score > 0.5);
    print_line(arguments, files[i].stem().string(), score, lines, error);
    if (!arguments.draw.empty())
      (void)image::write_image(arguments.draw / (method_name + "_" + files[i].stem().string() + ".png"),
                               overlay(*picture, lines));
  }
  if (tally.scores.empty()) return {};
  std::printf(
      "CRBD  %-7s n %3zu  CRDA %.3f (quarters from the top %.2f %.2f %.2f %.2f)  spacing<5%% %.3f  ms mean "
      "%.2f median %.2f  right at confidence 0.9: %d of %d\n",
      method_name.c_str(), tally.scores.size(), stats::mean(tally.scores), stats::mean(tally.by_quarter[0]),
      stats::mean(tally.by_quarter[1]), stats::mean(tally.by_quarter[2]), stats::mean(tally.by_quarter[3]),
      tally.right / static_cast<double>(tally.scores.size()), stats::mean(tally.ms), stats::median(tally.ms),
      tally.sure_right, tally.sure);
  return tally.answers;
}

void bench_bound(const Arguments& arguments) {
  for (const bool with_bend2 : {false, true}) {
    std::vector<double> scores;
    const auto files = pictures_in(arguments.data / "rows/crbd-train");
    for (std::size_t i = 0; i < files.size(); ++i) {
      if (!in_half(i, arguments.half)) continue;
      const CrbdTruth truth = read_crp(fs::path(files[i]).replace_extension(".crp"));
      const auto field = fit_to_truth(truth, with_bend2);
      const double score = crda(truth, [&](int k, double v) -> std::optional<double> {
                             if (field.scale(v) <= 0.0) return std::nullopt;
                             return field.u_at(v, k);
                           }).value;
      scores.push_back(score);
      if (arguments.list)
        std::printf("  %-22s score %.3f g %.3f bend %.2f bend2 %.3f\n", files[i].stem().string().c_str(),
                    score, field.convergence, field.bend, field.bend2);
    }
    if (!scores.empty())
      std::printf("CRBD  bound %s n %3zu  CRDA %.3f\n", with_bend2 ? "two bends" : "one bend", scores.size(),
                  stats::mean(scores));
  }
}

/// u of a polyline of [v, u] points at v, extended along its end segments.
std::optional<double> polyline_u(const base::Array& points, double v) {
  std::vector<std::pair<double, double>> line;
  for (const base::Value& point : points) {
    const base::Array* pair = point.array();
    if (pair == nullptr || pair->size() != 2) return std::nullopt;
    line.emplace_back((*pair)[0].number().value_or(0.0), (*pair)[1].number().value_or(0.0));
  }
  std::sort(line.begin(), line.end());
  if (line.size() < 2 || v < line.front().first - 8.0 || v > line.back().first + 8.0) return std::nullopt;
  for (std::size_t i = 1; i < line.size(); ++i) {
    if (v > line[i].first && i + 1 < line.size()) continue;
    const auto& [v0, u0] = line[i - 1];
    const auto& [v1, u1] = line[i];
    return u0 + (u1 - u0) * (v - v0) / (v1 - v0);
  }
  return std::nullopt;
}

struct CentreRow {
  double high = 0.0, low = 0.0;
};

std::optional<CentreRow> true_centre(const base::Array& lines, double width, double height) {
  std::optional<CentreRow> best;
  double nearest = width;
  for (const base::Value& line : lines) {
    if (line.array() == nullptr) continue;
    const auto middle = polyline_u(*line.array(), 0.75 * height);
    const auto high = polyline_u(*line.array(), 0.6 * height), low = polyline_u(*line.array(), 0.9 * height);
    if (!middle || !high || !low || std::abs(*middle - 0.5 * width) >= nearest) continue;
    nearest = std::abs(*middle - 0.5 * width);
    best = CentreRow{*high, *low};
  }
  return best;
}

std::optional<CentreRow> found_centre(const rows::RowLines& lines) {
  std::optional<CentreRow> best;
  double nearest = lines.width;
  for (const rows::RowLine& row : lines.rows) {
    const auto middle = rows::u_at(row, 0.75 * lines.height);
    const auto high = rows::u_at(row, 0.6 * lines.height), low = rows::u_at(row, 0.9 * lines.height);
    if (!middle || !high || !low || std::abs(*middle - 0.5 * lines.width) >= nearest) continue;
    nearest = std::abs(*middle - 0.5 * lines.width);
    best = CentreRow{*high, *low};
  }
  return best;
}

std::vector<bench::Answer> bench_crdld(const Arguments& arguments, rows::Method method,
                                       const std::string& method_name) {
  const auto folder = arguments.data / "rows/crdld-train";
  const auto files = pictures_in(folder);
  if (files.empty()) return {};
  const auto document = base::read_json(folder / "lines.json");
  if (!document.ok()) return {};
  Tally tally;
  int any_right = 0;
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (!in_half(i, arguments.half)) continue;
    const base::Value* entry =
        document->find("images") ? document->find("images")->find(files[i].filename().string()) : nullptr;
    const auto picture = image::read_image(files[i]);
    if (!picture.ok() || entry == nullptr || entry->array() == nullptr) continue;
    const auto truth = true_centre(*entry->array(), picture->width, picture->height);
    if (!truth) continue;
    double ms = 0.0;
    const auto lines = timed_detect(*picture, method, ms);
    const double tolerance = kCentreTolerance * picture->width;
    const auto found = found_centre(lines);
    const auto is_right = [&](double high, double low) {
      return std::abs(high - truth->high) < tolerance && std::abs(low - truth->low) < tolerance;
    };
    const bool right = found && is_right(found->high, found->low);
    bool any = false;
    for (const rows::RowLine& row : lines.rows) {
      const auto high = rows::u_at(row, 0.6 * lines.height), low = rows::u_at(row, 0.9 * lines.height);
      any = any || (high && low && is_right(*high, *low));
    }
    any_right += any;
    tally.right += right;
    tally.count_confidence(lines.confidence, right);
    tally.scores.push_back(right);
    tally.ms.push_back(ms);
    print_line(arguments, files[i].stem().string(), right, lines, any);
    if (!arguments.draw.empty())
      (void)image::write_image(arguments.draw / (method_name + "_crdld_" + files[i].stem().string() + ".png"),
                               overlay(*picture, lines));
  }
  if (tally.scores.empty()) return {};
  std::printf(
      "CRDLD %-7s n %3zu  centre row right %.3f  (some row right %.3f)  ms mean %.2f  right at confidence "
      "0.9: %d of %d\n",
      method_name.c_str(), tally.scores.size(), stats::mean(tally.scores),
      any_right / static_cast<double>(tally.scores.size()), stats::mean(tally.ms), tally.sure_right,
      tally.sure);
  return tally.answers;
}

/// CRDA and spacings on perturbed copies, by kind.
void bench_perturbed(const Arguments& arguments, rows::Method method, const std::string& method_name) {
  std::map<std::string, Tally> tallies;
  const auto files = pictures_in(arguments.data / "rows/crbd-train");
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (!in_half(i, arguments.half)) continue;
    const auto original = image::read_image(files[i]);
    if (!original.ok()) continue;
    const CrbdTruth truth = read_crp(fs::path(files[i]).replace_extension(".crp"));
    for (const bench::Perturbed& copy : bench::perturbed_copies(*original)) {
      double ms = 0.0;
      const auto lines = bench::in_original(timed_detect(copy.picture, method, ms), copy, *original);
      const RowPlace place = place_in(lines);
      for (const std::string& name : {copy.name, std::string("all copies")}) {
        tallies[name].scores.push_back(crda(truth, place).value);
        tallies[name].right += spacing_error(truth, place) < kSpacingTolerance;
      }
    }
  }
  for (const auto& [name, tally] : tallies)
    std::printf("CRBD  %-7s %-10s n %3zu  CRDA %.3f  spacing<5%% %.3f\n", method_name.c_str(), name.c_str(),
                tally.scores.size(), stats::mean(tally.scores),
                tally.right / static_cast<double>(tally.scores.size()));
}

/// Median over pictures of the least thread time of three runs.
void bench_times(const Arguments& arguments, rows::Method method, const std::string& method_name) {
  constexpr int kRuns = 3, kEvery = 4;
  for (const auto& [width, height] : {std::pair{320, 240}, {1280, 720}}) {
    std::vector<double> times;
    for (const char* folder : {"rows/crbd-train", "rows/crdld-train", "flights/mini-se/mid_corn"}) {
      const auto files = pictures_in(arguments.data / folder);
      for (std::size_t i = 0; i < files.size(); i += kEvery) {
        const auto original = image::read_image(files[i]);
        if (!original.ok()) continue;
        const Image picture = image::resize(*original, width, height);
        double least = 1e9;
        for (int run = 0; run < kRuns; ++run) {
          double ms = 0.0;
          (void)timed_detect(picture, method, ms);
          least = std::min(least, ms);
        }
        times.push_back(least);
      }
    }
    if (!times.empty())
      std::printf("time  %-7s %dx%d  n %zu  median %.2f ms  mean %.2f  most %.2f\n", method_name.c_str(),
                  width, height, times.size(), stats::median(times), stats::mean(times),
                  *std::max_element(times.begin(), times.end()));
  }
}

Arguments read_arguments(int argc, char** argv) {
  Arguments arguments;
  const char* data = std::getenv("FURROW_DATA");
  arguments.data = data != nullptr ? fs::path(data) : fs::path(FURROW_SOURCE_DIR) / "../shared/data";
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    const std::string value = i + 1 < argc ? argv[i + 1] : "";
    const std::map<std::string, bool*> flags = {{"--list", &arguments.list},
                                                {"--perturbed", &arguments.perturbed},
                                                {"--sweep", &arguments.sweep},
                                                {"--times", &arguments.times}};
    if (const auto flag = flags.find(name); flag != flags.end()) {
      *flag->second = true;
      continue;
    }
    ++i;
    if (name == "--data") arguments.data = value;
    if (name == "--half") arguments.half = value;
    if (name == "--method") arguments.method = value;
    if (name == "--draw") arguments.draw = value;
  }
  return arguments;
}

}  // namespace

int main(int argc, char** argv) {
  const Arguments arguments = read_arguments(argc, argv);
  const auto wanted = [&](const char* name) { return arguments.method.empty() || arguments.method == name; };
  if (wanted("bound")) bench_bound(arguments);
  for (const auto& [name, method] :
       {std::pair{"thesis", rows::Method::thesis}, std::pair{"field", rows::Method::field}}) {
    if (!wanted(name)) continue;
    std::vector<bench::Answer> answers = bench_crbd(arguments, method, name);
    const auto add = [&](const std::vector<bench::Answer>& more) {
      answers.insert(answers.end(), more.begin(), more.end());
    };
    add(bench_crdld(arguments, method, name));
    print_reliability(name, answers);
    if (arguments.perturbed) bench_perturbed(arguments, method, name);
    if (arguments.times) bench_times(arguments, method, name);
    if (!arguments.sweep) continue;
    const auto drawn = bench::print_row_sweep(method, name);
    print_reliability(name, drawn);
    add(drawn);
    print_reliability(name, answers);
  }
  return 0;
}
