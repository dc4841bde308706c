#pragma once
#include <vector>

#include "furrow/altitude/fuse.h"
#include "furrow/audit/shot_record.h"
#include "furrow/audit/truth.h"
#include "furrow/base/csv.h"

namespace furrow::audit {

/// The same flight fused with one source switched off.
struct FusionTrial {
  altitude::HeightSource off = altitude::HeightSource::vision;
  Result<altitude::FusedFlight> fused;
};

/// Heights of a flight from all its sources together, and what each of them is worth.
struct FlightFusion {
  std::vector<std::size_t> shots;  ///< place of each sample among the flight's records; in order of time
  std::vector<altitude::HeightSample> samples;
  altitude::FusedFlight fused;
  std::vector<FusionTrial> without;  ///< one for each source that spoke
  /// How far the rows' outline stands above the top that the farm names (FieldKnowledge::outline_rise_m): as
  /// the pictures' heights took it, and as all sources together have it: over the row height that was stated.
  /// Unusable without such heights; told only where a downward sensor saw leaves and soil.
  Estimate rise_taken_m, rise_told_m;
};

/// Sources with at least one reading in the flight.
std::vector<altitude::HeightSource> speaking_sources(const FlightFusion& fusion);

/// fusion.csv: a row per sample with the fused heights, and each speaking source's reading, residual (reading
/// minus what all say, bias taken off) and use ("used", "gated"; what a downward sensor saw).
base::CsvTable fusion_table(const std::vector<ShotRecord>& records, const FlightFusion& fusion);

/// Per source: readings used and gated, RMS residual, bias at the end with its sigma.
base::CsvTable sources_table(const FlightFusion& fusion);

/// All sources, then each switched off: mean sigma and RMS distance from the heights of all sources; where a
/// trial gave no height, its reason stands in the last column.
base::CsvTable trials_table(const FlightFusion& fusion);

/// Tells a person the rise of the outline where all sources together have it clearly better than the pictures
/// took it, and what to write in project.yaml; empty elsewhere.
std::string rise_words(const FlightFusion& fusion);

/// "fused, all sources", "fused without vision", ... against the records' truths; empty without truth.
std::vector<TruthComparison> compare_fusion(const std::vector<ShotRecord>& records,
                                            const FlightFusion& fusion);

}  // namespace furrow::audit
