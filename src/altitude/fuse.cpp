#include "furrow/altitude/fuse.h"

#include <algorithm>
#include <cmath>

#include "furrow/base/text.h"
#include "fusion_results.h"

namespace furrow::altitude {
namespace {

/// Whether a picture's height, where there is one, can be weighed against others.
bool weighable(const Estimate& height, const std::vector<SigmaShare>& shared, double reach_m) {
  if (!height.usable()) return true;  // silent
  return height.sigma > 0.0 && std::isfinite(reach_m) &&
         std::all_of(shared.begin(), shared.end(),
                     [](const SigmaShare& share) { return std::isfinite(share.sigma_m); });
}

Status check_samples(const std::vector<HeightSample>& samples) {
  if (samples.empty()) return Error{"no_samples", "fuse", "no samples", "one sample or more", ""};
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const HeightSample& sample = samples[i];
    const std::string where = "sample " + std::to_string(i + 1);
    if (!(std::isfinite(sample.t_s) && (i == 0 || sample.t_s > samples[i - 1].t_s))) {
      return Error{"times_not_increasing", where, base::format_double(sample.t_s) + " s",
                   "a finite time after the one before", ""};
    }
    if (!weighable(sample.vision_above_canopy_m, sample.vision_shared, sample.vision_reach_m) ||
        !weighable(sample.depth_above_canopy_m, sample.depth_shared, 0.0)) {
      return Error{"not_finite", where,
                   "a picture's height with a sigma of 0, or with shares or reach that are not finite",
                   "a sigma above 0, finite shares and reach", ""};
    }
  }
  return Done{};
}

Status check_options(const FuseOptions& options) {
  const auto refuse = [](double value, const char* wanted) {
    return Error{"not_finite", "fuse options", base::format_double(value), wanted, ""};
  };
  for (const double sigma : {options.acceleration_sigma, options.baro_sigma_m, options.vps_sigma_m,
                             options.gnss_sigma_m, options.depth_bias_sigma_m, options.gate_sigmas}) {
    if (!(std::isfinite(sigma) && sigma > 0.0)) return refuse(sigma, "finite sigmas above 0");
  }
  for (const double sigma : {options.vps_canopy_sigma_m, options.ground_rate_sigma, options.ground_rate_drift,
                             options.baro_drift_m_per_sqrt_s, options.gnss_drift_m_per_sqrt_s}) {
    if (!(std::isfinite(sigma) && sigma >= 0.0)) return refuse(sigma, "a finite sigma, not below 0");
  }
  return Done{};
}

/// Some source must tell the height itself, not only its changes.
Status check_sources(const std::vector<HeightSample>& samples, const FusionSetup& setup) {
  if (any_absolute(samples, setup)) return Done{};
  if (!any(samples, HeightSource::vps, setup)) {
    return Error{"no_absolute_height", "fuse", "only barometer or GNSS, whose zero is not known",
                 "vision, depth or a downward sensor", ""};
  }
  if (setup.options.row_height_m.usable()) return Done{};
  return Error{"no_row_height", "fuse", "a downward sensor alone, and no height of the rows",
               "the rows' height", ""};
}

/// Every cause that some picture shares, once.
std::vector<std::string> causes_of(const std::vector<HeightSample>& samples) {
  std::vector<std::string> causes;
  const auto add = [&causes](const std::vector<SigmaShare>& shares) {
    for (const SigmaShare& share : shares) {
      if (std::find(causes.begin(), causes.end(), share.cause) == causes.end()) causes.push_back(share.cause);
    }
  };
  for (const HeightSample& sample : samples) {
    add(sample.vision_shared);
    add(sample.depth_shared);
  }
  return causes;
}

}  // namespace

std::string source_name(HeightSource source) {
  static const char* const kNames[kHeightSources] = {"vision", "depth", "baro", "vps", "gnss"};
  return kNames[place(source)];
}

Result<FusedFlight> fuse(const std::vector<HeightSample>& samples, const FuseOptions& options) {
  const FusionSetup setup{options, causes_of(samples)};
  FURROW_DO(check_samples(samples));
  FURROW_DO(check_options(options));
  FURROW_DO(check_sources(samples, setup));
  return describe(samples, settle(samples, setup));
}

}  // namespace furrow::altitude
