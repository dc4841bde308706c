#pragma once
#include <array>
#include <limits>
#include <string>
#include <vector>

#include "furrow/altitude/shot_height.h"
#include "furrow/base/result.h"
#include "furrow/stats/estimate.h"

namespace furrow::altitude {

/// All that speaks about height at one moment; NaN or an unusable Estimate where a source is silent.
struct HeightSample {
  double t_s = 0.0;
  Estimate vision_above_canopy_m;  ///< refine_shot's or refine_flight's
  /// The part of its sigma that is not this shot's own: for each cause that other shots name too (spacing,
  /// gimbal bias, outline, ...) the metres by which one sigma of it moves this height. Such errors do not
  /// average out. Empty: every shot errs on its own.
  std::vector<SigmaShare> vision_shared;
  /// How far ahead the optical axis meets the canopy: over ground that curves by c the picture's plane lies
  /// c reach²/2 off the canopy straight below. 0: not known, or straight down.
  double vision_reach_m = 0.0;
  Estimate depth_above_canopy_m;         ///< from a depth map; may carry a constant bias
  std::vector<SigmaShare> depth_shared;  ///< as vision_shared: scale of the network, gimbal
  double baro_height_m = std::numeric_limits<double>::quiet_NaN();  ///< above any fixed level; drifts
  double vps_height_m = std::numeric_limits<double>::quiet_NaN();   ///< above what is below: leaves or soil
  double gnss_height_m =
      std::numeric_limits<double>::quiet_NaN();  ///< above any fixed level, ground level there; constant bias
};

enum class HeightSource { vision, depth, baro, vps, gnss };
inline constexpr int kHeightSources = 5;
inline constexpr std::array<HeightSource, kHeightSources> kAllHeightSources = {
    HeightSource::vision, HeightSource::depth, HeightSource::baro, HeightSource::vps, HeightSource::gnss};
/// "vision", "depth", ...
std::string source_name(HeightSource source);

struct FuseOptions {
  /// Top of the canopy above the soil, with sigma.
  Estimate row_height_m;
  /// One-sigma of the vertical acceleration of the aircraft, m/s^2: how fast its climb may change. Default:
  /// gentle crop flight.
  double acceleration_sigma = 0.3;
  /// One-sigma of a barometer's reading, and of its drift in one second. Defaults: small MEMS barometers;
  /// half a metre in a quarter of an hour.
  double baro_sigma_m = 0.15;
  double baro_drift_m_per_sqrt_s = 0.02;
  /// The canopy's level below the aircraft rises and falls with the ground, which barometer and GNSS do not
  /// see: one-sigma of its rate, m/s, and of the rate's change in one second. Defaults: 5 % at 1 m/s, and
  /// waves of some tens of metres.
  double ground_rate_sigma = 0.05;
  double ground_rate_drift = 0.02;
  /// One-sigma of a downward sensor's reading over leaves or soil.
  double vps_sigma_m = 0.10;
  /// One-sigma of how far the leaves that a downward sensor hits lie under or over the top that row_height_m
  /// names: what is called the top is a matter of words, for the sensor as for the outline. Common to the
  /// flight. Default: for rows of unknown width; typical_rise_sigma_m of theirs, or what pictures leave open
  /// of the outline, where that is known.
  double vps_canopy_sigma_m = typical_rise_sigma_m();
  /// So many shots in a row see much the same plants, and what is a shot's own error in its rows lasts as
  /// long (FlightOptions::shots_per_stretch). 1: from shot to shot independent.
  double shots_per_stretch = 4.0;
  /// One-sigma of a GNSS height about its bias, and of the bias's change in one second.
  double gnss_sigma_m = 0.5;
  double gnss_drift_m_per_sqrt_s = 0.02;
  /// One-sigma of the constant bias of a depth map's height. The others' offsets are unknown altogether.
  double depth_bias_sigma_m = 0.5;
  /// A reading farther from the others than this many sigmas of its difference is left out.
  double gate_sigmas = 4.0;
  /// Sources that take part, by HeightSource.
  std::array<bool, kHeightSources> use = {true, true, true, true, true};
};

/// What a downward sensor saw.
enum class Seen { nothing, canopy, soil, outlier };

struct FusedHeight {
  double t_s = 0.0;
  Estimate above_canopy_m, above_ground_m;
  /// Reading minus what all sources together say, bias taken off, by HeightSource; NaN where silent.
  std::array<double, kHeightSources> residual_m;
  std::array<bool, kHeightSources> left_out;  ///< there, but gated as an outlier
  Seen vps_seen = Seen::nothing;
};

/// What all sources together make of a cause that the pictures share (HeightSample::vision_shared): 0 +- 1
/// where they leave it as it was claimed, above 0 where it makes the pictures' heights too large.
struct SharedCause {
  std::string cause;
  Estimate error_sigmas;  ///< in the sigmas that were claimed of it
};

struct FusedFlight {
  std::vector<FusedHeight> heights;
  std::vector<SharedCause> causes;  ///< in the order in which the samples name them
  Estimate baro_bias_m, gnss_bias_m, depth_bias_m;  ///< at the last sample: reading minus height above canopy
  std::array<int, kHeightSources> used = {};        ///< readings that took part
  std::array<int, kHeightSources> gated = {};
  std::array<double, kHeightSources> residual_rms_m = {};  ///< of those used; NaN for none
  /// The noise that the flight shows over the noise that was claimed, drawn to 1 by 20 readings' worth.
  std::array<double, kHeightSources> noise_scale = {1.0, 1.0, 1.0, 1.0, 1.0};
  /// One-sigma of the ground's curvature, 1/m, that the other sources' disagreement with vision shows; 0 for
  /// ground that is flat as far as they tell.
  double ground_curvature_per_m = 0.0;
  int passes = 0;  ///< of smoothing, from all starts, until nothing changed
  /// Only a downward sensor fixes the height, and it never changed its level: leaves or soil is a guess, and
  /// the row height stands in the sigma.
  bool surface_open = false;
};

/// Kalman smoother over the flight (docs/formulation/altitude.md, section 11) with height, climb and each
/// source's bias as state; a downward sensor's reading is taken as canopy, soil or neither, and outliers are
/// gated, until nothing changes; where that sensor's own steps tell its surfaces, from the likelier of two
/// starts. Errors: no_samples, times_not_increasing, not_finite (options; a picture's height of sigma 0),
/// no_absolute_height (only sources with unknown offset), no_row_height (VPS alone fixes the height, and the
/// canopy's height is not known).
Result<FusedFlight> fuse(const std::vector<HeightSample>& samples, const FuseOptions& options);

}  // namespace furrow::altitude
