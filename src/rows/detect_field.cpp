#include "rows/detect_field.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "furrow/base/text.h"
#include "furrow/base/whole.h"
#include "rows/edge_pencil.h"
#include "rows/field_search.h"
#include "rows/green_map.h"
#include "rows/index_rows.h"
#include "rows/leaf_edges.h"
#include "rows/leaf_map.h"
#include "rows/levelled.h"
#include "rows/row_shape.h"

namespace furrow::rows {
namespace {

constexpr double kSearchPixels =
    320.0 * 240.0;  // of the search: rows a few px apart are still told apart, and it takes milliseconds

/// FoundField::explained of a field that is beyond doubt: clear pictures have more.
constexpr double kLeastExplained = 0.7;

/// Row k at the model's places: from top to bottom where it is in the picture or less than a spacing outside.
RowLine row_of(const CommonModel& model, int k, int width, const std::vector<double>& sample_v) {
  constexpr double kUnseenSigma = 0.05;  // spacings: how well the model alone places a row
  RowLine row;
  row.index = k;
  for (const double v : sample_v) {
    if (model.field().scale(v) <= 0.02) continue;
    const Cut cut = model.at(v);
    const double u = cut.centre + k * cut.spacing;
    if (u < -cut.spacing || u > width - 1.0 + cut.spacing) continue;
    RowSample sample;
    sample.centre_px = {u, v};
    sample.sigma_px = kUnseenSigma * cut.spacing;
    sample.seen = u >= 0.0 && u <= width - 1.0;
    row.samples.push_back(sample);
  }
  return row;
}

/// Every row that crosses the picture below the horizon, with its own centres and edges.
std::vector<RowLine> shaped_rows(const SummedMap& map, const CommonModel& model, int width,
                                 const std::vector<double>& sample_v) {
  const int farthest = 10 * width;  // row numbers: those of rows a tenth of a pixel apart
  int first = 0, last = -1;
  for (const double v : sample_v) {
    if (model.field().scale(v) < 0.1) continue;
    const Cut cut = model.at(v);
    const int left = base::ceil_between(-cut.centre / cut.spacing, -farthest, farthest);
    const int right = base::floor_between((width - 1.0 - cut.centre) / cut.spacing, -farthest, farthest);
    first = last < first ? left : std::min(first, left);
    last = std::max(last, right);
  }
  std::vector<RowLine> rows;
  for (int k = first; k <= last; ++k) {
    RowLine row = row_of(model, k, width, sample_v);
    if (row.samples.size() >= 2) rows.push_back(std::move(row));
  }
  shape_rows(map, model, rows);
  return rows;
}

/// A model with its rows straight.
struct Straightened {
  CommonModel model;
  double row_zero = 0.0;  ///< the row that is its row 0 had this number before
};

/// The model with its rows straight towards `point`, where they are on the picture row that the search fits
/// best. Row 0 becomes the followed one.
Straightened straightened(const CommonModel& model, const Eigen::Vector2d& point, int width, int height) {
  const Cut cut = model.at(0.7 * height);
  const PlanarField field = field_through(model.field(), point, cut.v, cut.centre, cut.spacing);
  const double v_middle = 0.5 * (height - 1);
  if (field.scale(v_middle) <= 0.0) return {CommonModel(field), 0.0};
  const double followed = std::round(field.k_at(0.5 * (width - 1), v_middle));
  return {CommonModel(field_through(field, point, cut.v, cut.centre + followed * cut.spacing, cut.spacing)),
          followed};
}

/// The model with row 0 at row number `middle` and its spacing so many times as wide.
CommonModel with_spacing(const CommonModel& model, double middle, double spacing) {
  PlanarField field = model.field();
  field.offset += middle * field.spacing;
  field.spacing *= spacing;
  return CommonModel(field);
}

FoundField in_map(const Previous& previous, const GreenMap& map) {
  FoundField found;
  found.tooth = previous.tooth;
  found.score = previous.score;
  found.field = previous.field;
  // Anchored at the map itself, so that a picture of another size is not taken at its word.
  found.field.u0 = 0.5 * (map.width - 1);
  found.field.v0 = map.height - 1.0;
  found.field.length = map.height;
  for (double* px :
       {&found.field.spacing, &found.field.offset, &found.field.slope, &found.field.bend, &found.field.bend2})
    *px /= map.scale_u;
  return found;
}

RowLines no_rows(RowLines lines, double score, double least_score) {
  lines.rows.clear();
  lines.field.reset();
  lines.vanishing_point_px.reset();
  lines.status = "no_rows";
  lines.reason = "no pattern of rows: score " + base::format_double(std::round(1e3 * score) / 1e3) +
                 ", wanted " + base::format_double(least_score) + " or more";
  return lines;
}

/// Probability that the rows are right: a logistic of the score through the development halves of CRBD and
/// CRDLD, where half of the pictures at a score of 0.10 and nine tenths at 0.18 were right
/// (docs/formulation/rows.md). Less where half strips show a pattern that the field leaves unexplained: it
/// may be another one.
double confidence_of(const FoundField& found) {
  constexpr double kEven = 0.10, kScale = 0.035;
  return std::min(1.0, found.explained / kLeastExplained) / (1.0 + std::exp(-(found.score - kEven) / kScale));
}

int edge_count(const std::vector<RowLine>& rows) {
  int count = 0;
  for (const RowLine& row : rows) {
    for (const RowSample& sample : row.samples)
      count += std::isfinite(sample.left_u_px) + std::isfinite(sample.right_u_px);
  }
  return count;
}

/// Where rows are thought to stand.
struct Guess {
  double slope = 0.0;  ///< the picture is levelled by it
  CommonModel model;
  double tooth = 0.0;            ///< visible width over the spacing
  std::optional<Relief> relief;  ///< in the model's row numbers
};

/// The rows of a levelled picture, and their tops where the rows are straight.
struct Look : Guess {
  SummedMap map;
  std::vector<double> sample_v;
  double tilt = 0.0;  ///< of the rows' own horizon
  std::vector<RowLine> rows;
  FoundTops tops;

  void shape(const CommonModel& by, int width) {
    model = by;
    rows = shaped_rows(map, model, width, sample_v);
  }
};

/// Straight rows towards where their edges meet, when the gimbal's horizon is known.
std::optional<Straightened> straight_model(const Image& picture, Priors priors, const Look& look) {
  priors.horizon_slope = look.tilt;
  const auto point = meeting_point(look.rows, priors, 0.5 * (picture.width - 1));
  return point ? std::optional(straightened(look.model, *point, picture.width, picture.height))
               : std::nullopt;
}

/// Takes straight rows, and their tops, where the rows are straight: along rows that bend or go over hills a
/// straight model loses edges.
void straighten(const Image& picture, const Priors& priors, Look& look) {
  // Of the edges: straight rows of renders kept 0.96 of them and more (one shot in thirty 0.88), rows over
  // hills 0.78 to 0.89.
  constexpr double kLeastKept = 0.9;
  const auto straight = straight_model(picture, priors, look);
  if (!straight) return;
  std::vector<RowLine> straight_rows = shaped_rows(look.map, straight->model, picture.width, look.sample_v);
  if (edge_count(straight_rows) < kLeastKept * edge_count(look.rows)) return;
  look.model = straight->model;
  if (look.relief) look.relief = look.relief->renumbered(-straight->row_zero);
  look.rows = std::move(straight_rows);
  look.tops = find_tops(look.map.map(), look.model, look.tilt, look.rows);
}

/// Gives the rows the tops' spacing, and the tops.
void take_tops(int width, Look& look) {
  const auto& tops = look.tops.comb;
  if (!tops) return;
  look.shape(with_spacing(look.model, tops->middle, tops->spacing), width);
  write_tops(*tops, look.model.field(), look.tilt, look.rows);
}

/// A search in the picture levelled by a slope of the horizon.
struct Searched {
  double slope = 0.0;
  GreenMap map;
  std::optional<FoundField> found;

  double score() const { return found ? found->score : 0.0; }
};

Searched search_levelled(const Image& picture, const DetectOptions& options, double slope) {
  Searched result;
  result.slope = slope;
  const GreenMap& map = result.map =
      green_map(slope == 0.0 ? picture : levelled(picture, slope), kSearchPixels);
  SearchPriors priors;
  if (options.priors.horizon_v_px) {
    priors.horizon_v = (*options.priors.horizon_v_px + 0.5) / map.scale_v - 0.5;
    priors.horizon_sigma = std::max(options.priors.horizon_sigma_px / map.scale_v, 1.0);
  }
  if (options.previous) result.found = continue_field(map, in_map(*options.previous, map), priors);
  if (!result.found) result.found = search_field(map, priors);
  return result;
}

/// Levels by what the rows show, where no roll was told. Where half strips show rows that the field does not
/// explain, the picture is looked at quickly with larger rolls too, and searched with the most promising.
Searched levelled_by_rows(const Image& picture, const DetectOptions& options, Searched best) {
  constexpr std::array kLargeSlopes = {-0.27, -0.13, 0.13, 0.27};
  constexpr double kClearly = 1.15;
  constexpr double kHarmless =
      0.06;  // rows are as right without, and uneven passes of a planter look like it
  constexpr int kRounds = 3;
  DetectOptions afresh = options;
  afresh.previous.reset();
  if (best.found && best.found->explained < kLeastExplained) {
    double promise = promise_of(best.map), promising = 0.0;
    for (const double slope : kLargeSlopes) {
      const double one = promise_of(levelled(best.map, slope));
      if (one > promise) promise = one, promising = slope;
    }
    if (promising != 0.0) {
      Searched other = search_levelled(picture, afresh, best.slope + promising);
      if (other.score() > kClearly * best.score()) best = std::move(other);
    }
  }
  for (int round = 0; round < kRounds && best.found && best.found->tilt != 0.0; ++round) {
    if (best.slope == 0.0 && std::abs(best.found->tilt) < kHarmless) break;
    Searched next = search_levelled(picture, afresh, best.slope + best.found->tilt);
    if (next.score() <= best.score()) break;
    best = std::move(next);
  }
  return best;
}

/// Of the levelled picture; the search's where that is fine enough.
GreenMap level_map(const Image& picture, double slope, double pixels, const Searched& searched) {
  const bool is_fine = std::min(pixels, 1.0 * picture.width * picture.height) <= kSearchPixels;
  if (is_fine && slope == searched.slope) return searched.map;
  return green_map(slope == 0.0 ? picture : levelled(picture, slope), pixels);
}

Look look_at(const Image& picture, const DetectOptions& options, const Searched& searched,
             const Guess& guess) {
  const double most_step = guess.slope == 0.0 ? 10.0 : 5.0;  // tilting may double a step
  const double told = options.priors.horizon_slope.value_or(0.0);
  Look look{guess,
            SummedMap(leaf_map(level_map(picture, guess.slope, options.shape_pixels, searched), guess.model,
                               guess.tooth, guess.relief)),
            sample_rows(picture.height, std::min({options.sample_step_px, most_step, picture.height / 60.0})),
            guess.slope == 0.0 ? told : 0.0,
            {},
            {}};
  look.shape(guess.model, picture.width);
  return look;
}

/// Levels the picture by what the tops show of a slope across, too; rows and tops are found again in it.
void level_by_tops(const Image& picture, const DetectOptions& options, const Searched& searched, Look& look) {
  constexpr double kLeastTilt = 0.02;  // a degree
  constexpr int kRounds = 2;
  for (int round = 0; round < kRounds && std::abs(look.tops.tilt) > kLeastTilt; ++round) {
    const double more = look.tilt + look.tops.tilt;
    const auto field = relevelled(look.model.field(), more, 0.5 * (picture.width - 1));
    if (!field) return;
    Look next = look_at(picture, options, searched,
                        {look.slope + more, CommonModel(*field), look.tooth, look.relief});
    next.tops = find_tops(next.map.map(), next.model, next.tilt, next.rows);
    if (next.tops.explained <= look.tops.explained) return;
    look = std::move(next);
  }
}

Look straight_look(const Image& picture, const DetectOptions& options, const Searched& searched,
                   const Guess& guess) {
  Look look = look_at(picture, options, searched, guess);
  straighten(picture, options.priors, look);
  level_by_tops(picture, options, searched, look);
  return look;
}

/// Where a look at a small picture shows tops, walls and ground; rows stand at its tops where these are not
/// the greenest stripes.
Guess guess_relief(const Image& picture, DetectOptions options, const Searched& searched,
                   const Guess& guess) {
  options.shape_pixels = kSearchPixels;
  Look look = straight_look(picture, options, searched, guess);
  const auto straight = straight_model(picture, options.priors, look);
  const auto found = straight ? find_relief(look.map.map(), straight->model.field()) : std::nullopt;
  if (!found) return look;
  const Relief& relief = found->relief;
  const double tooth = 2.0 * relief.half_width / relief.spacing;
  if (!found->elsewhere) return {look.slope, look.model, tooth, relief.renumbered(straight->row_zero)};
  return {look.slope, with_spacing(straight->model, relief.middle, relief.spacing), tooth,
          relief.in_own_rows()};
}

/// Rows in the picture levelled by the search's slope; where their tops show that the ground slopes across,
/// by that too.
Look look_on_slope(const Image& picture, const DetectOptions& options, const Searched& searched) {
  Guess guess{searched.slope, CommonModel(*searched.found, searched.map), searched.found->tooth, {}};
  if (options.priors.horizon_v_px) guess = guess_relief(picture, options, searched, guess);
  Look look = straight_look(picture, options, searched, guess);
  take_tops(picture.width, look);
  return look;
}

}  // namespace

std::optional<Previous> previous_of(const RowLines& lines) {
  if (!lines.ok() || !lines.field) return std::nullopt;
  return Previous{*lines.field, lines.tooth, lines.score, lines.horizon_slope};
}

RowLines detect_field(const Image& picture, const DetectOptions& options) {
  // Less than the first moves the field by less than noise does; beyond the second nothing was ever level.
  constexpr double kLeastSlope = 0.01, kMostSlope = 1.0;
  if (picture.empty()) return begun(picture, "field");
  const auto& told = options.priors.horizon_slope;
  double slope = told.value_or(options.previous ? options.previous->horizon_slope : 0.0);
  if (!(std::abs(slope) > kLeastSlope && std::abs(slope) < kMostSlope)) slope = 0.0;
  Searched searched = search_levelled(picture, options, slope);
  if (!told) searched = levelled_by_rows(picture, options, std::move(searched));
  RowLines lines = begun(picture, "field");
  const auto& found = searched.found;
  if (!found || found->score < options.least_score)
    return no_rows(lines, searched.score(), options.least_score);
  Look look = look_on_slope(picture, options, searched);
  lines.rows = std::move(look.rows);
  lines.field = look.model.field();
  lines.vanishing_point_px = lines.field->vanishing_point();
  count_from_followed(lines);
  lines.status = "ok";
  lines.score = found->score;
  lines.tooth = found->tooth;
  lines.confidence = confidence_of(*found);
  if (look.slope != 0.0) tilt_back(lines, look.slope);
  return lines.rows.empty() ? no_rows(lines, found->score, options.least_score) : lines;
}

}  // namespace furrow::rows
