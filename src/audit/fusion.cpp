#include "furrow/audit/fusion.h"

#include <cmath>

#include "furrow/base/text.h"
#include "furrow/stats/robust.h"

namespace furrow::audit {
namespace {

using altitude::FusedFlight;
using altitude::FusedHeight;
using altitude::HeightSample;
using altitude::HeightSource;
using altitude::Seen;
using base::format_fixed;

std::size_t place(HeightSource source) {
  return static_cast<std::size_t>(source);
}

std::string number(double value, int decimals) {
  return std::isfinite(value) ? format_fixed(value, decimals) : std::string();
}

double reading_of(const HeightSample& sample, HeightSource source) {
  switch (source) {
    case HeightSource::vision:
      return sample.vision_above_canopy_m.value;
    case HeightSource::depth:
      return sample.depth_above_canopy_m.value;
    case HeightSource::baro:
      return sample.baro_height_m;
    case HeightSource::vps:
      return sample.vps_height_m;
    case HeightSource::gnss:
      return sample.gnss_height_m;
  }
  return std::nan("");
}

std::string use_of(const FusedHeight& height, HeightSource source) {
  if (!std::isfinite(height.residual_m[place(source)])) return "";
  if (height.left_out[place(source)]) return "gated";
  if (source != HeightSource::vps) return "used";
  return height.vps_seen == Seen::soil ? "used, saw soil" : "used, saw canopy";
}

/// The bias of a source that has one.
Estimate bias_of(const FusedFlight& fused, HeightSource source) {
  if (source == HeightSource::baro) return fused.baro_bias_m;
  if (source == HeightSource::gnss) return fused.gnss_bias_m;
  if (source == HeightSource::depth) return fused.depth_bias_m;
  return {};
}

std::vector<std::string> trial_row(const std::string& name, const FusedFlight& fused,
                                   const FusedFlight& all) {
  std::vector<double> sigmas, differences;
  for (std::size_t i = 0; i < fused.heights.size(); ++i) {
    sigmas.push_back(fused.heights[i].above_canopy_m.sigma);
    differences.push_back(fused.heights[i].above_canopy_m.value - all.heights[i].above_canopy_m.value);
  }
  return {name, std::to_string(sigmas.size()), number(stats::mean(sigmas), 3),
          number(stats::root_mean_square(differences), 3), ""};
}

TruthComparison against_truth(const std::string& name, const std::vector<ShotRecord>& records,
                              const FlightFusion& fusion, const FusedFlight& fused) {
  std::vector<Estimate> heights;
  std::vector<double> truths;
  for (std::size_t i = 0; i < fusion.shots.size(); ++i) {
    heights.push_back(fused.heights[i].above_canopy_m);
    truths.push_back(records[fusion.shots[i]].truth_above_canopy_m);
  }
  return compare(name, heights, truths);
}

std::string trial_name(const FusionTrial& trial) {
  return "fused without " + altitude::source_name(trial.off);
}

constexpr const char* kAllSources = "fused, all sources";

}  // namespace

std::vector<HeightSource> speaking_sources(const FlightFusion& fusion) {
  std::vector<HeightSource> speaking;
  for (const HeightSource source : altitude::kAllHeightSources) {
    for (const HeightSample& sample : fusion.samples) {
      if (!std::isfinite(reading_of(sample, source))) continue;
      speaking.push_back(source);
      break;
    }
  }
  return speaking;
}

base::CsvTable fusion_table(const std::vector<ShotRecord>& records, const FlightFusion& fusion) {
  const auto sources = speaking_sources(fusion);
  base::CsvTable table;
  table.source = "fusion.csv";
  table.columns = {"shot_id",
                   "t_s",
                   "above_canopy_fused_m",
                   "above_canopy_fused_sigma_m",
                   "above_ground_fused_m",
                   "above_ground_fused_sigma_m"};
  for (const HeightSource source : sources) {
    const std::string name = altitude::source_name(source);
    table.columns.insert(table.columns.end(), {name + "_m", name + "_residual_m", name + "_use"});
  }
  for (std::size_t i = 0; i < fusion.samples.size(); ++i) {
    const FusedHeight& height = fusion.fused.heights[i];
    auto& row = table.rows.emplace_back(std::vector<std::string>{
        records[fusion.shots[i]].shot_id, number(height.t_s, 3), number(height.above_canopy_m.value, 4),
        number(height.above_canopy_m.sigma, 4), number(height.above_ground_m.value, 4),
        number(height.above_ground_m.sigma, 4)});
    for (const HeightSource source : sources) {
      row.push_back(number(reading_of(fusion.samples[i], source), 4));
      row.push_back(number(height.residual_m[place(source)], 4));
      row.push_back(use_of(height, source));
    }
  }
  return table;
}

base::CsvTable sources_table(const FlightFusion& fusion) {
  base::CsvTable table;
  table.columns = {"source", "readings used", "gated", "RMS residual m", "bias at the end m", "its sigma m"};
  for (const HeightSource source : speaking_sources(fusion)) {
    const Estimate bias = bias_of(fusion.fused, source);
    table.rows.push_back({altitude::source_name(source), std::to_string(fusion.fused.used[place(source)]),
                          std::to_string(fusion.fused.gated[place(source)]),
                          number(fusion.fused.residual_rms_m[place(source)], 3), number(bias.value, 2),
                          number(bias.sigma, 2)});
  }
  return table;
}

base::CsvTable trials_table(const FlightFusion& fusion) {
  base::CsvTable table;
  table.columns = {"sources", "shots", "mean sigma m", "RMS distance from all sources m", "why no height"};
  table.rows.push_back(trial_row(kAllSources, fusion.fused, fusion.fused));
  for (const FusionTrial& trial : fusion.without) {
    if (trial.fused.ok()) {
      table.rows.push_back(trial_row(trial_name(trial), *trial.fused, fusion.fused));
    } else {
      table.rows.push_back({trial_name(trial), "0", "", "", trial.fused.error().found});
    }
  }
  return table;
}

std::string rise_words(const FlightFusion& fusion) {
  constexpr double kClearly = 0.7;  // of the sigma that it was taken with
  const Estimate &taken = fusion.rise_taken_m, &told = fusion.rise_told_m;
  if (!told.usable() || !(told.sigma < kClearly * taken.sigma)) return {};
  const auto metres = [](const Estimate& e) {
    return format_fixed(e.value, 2) + " +- " + format_fixed(e.sigma, 2) + " m";
  };
  return "The rows' outline stands " + metres(told) +
         " over the top that height_m states, as pictures and a downward sensor that saw leaves and soil "
         "have it together; the pictures' heights took it for " +
         metres(taken) + ". For flights over the same crop without such a sensor write outline_rise_m: " +
         format_fixed(told.value, 2) + " and outline_rise_sigma_m: " + format_fixed(told.sigma, 2) +
         " under rows in project.yaml, beside the same height_m.";
}

std::vector<TruthComparison> compare_fusion(const std::vector<ShotRecord>& records,
                                            const FlightFusion& fusion) {
  std::vector<TruthComparison> lines = {against_truth(kAllSources, records, fusion, fusion.fused)};
  if (lines[0].shots == 0) return {};
  for (const FusionTrial& trial : fusion.without) {
    if (trial.fused.ok()) lines.push_back(against_truth(trial_name(trial), records, fusion, *trial.fused));
  }
  return lines;
}

}  // namespace furrow::audit
