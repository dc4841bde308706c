#include "furrow/project/follow_job.h"

#include <algorithm>

#include "furrow/base/parallel.h"
#include "furrow/base/text.h"
#include "project/by_hand.h"
#include "project/follow_outputs.h"
#include "project/picture_queue.h"

namespace furrow::project {
namespace {

/// Everything that takes the pictures in their order, one at a time.
class Sequence {
 public:
  explicit Sequence(const FollowJobOptions& options) : options_(&options) {}

  Status open(double nominal_rate_hz) {
    if (options_->by_hand) {
      FURROW_TRY(ByHand read, ByHand::read(*options_->by_hand));
      by_hand_ = std::move(read);
    }
    if (options_->steer_to) {
      FURROW_TRY(follow::SteeringLink link, follow::SteeringLink::open(*options_->steer_to));
      sender_.emplace(std::move(link));
    }
    if (options_->out) {
      FURROW_TRY(FollowFiles files, FollowFiles::create(*options_, nominal_rate_hz));
      files_ = std::move(files);
    }
    return Done{};
  }

  /// False when the caller wants no more.
  Result<bool> add(SeenPicture seen) {
    following_ = follow::follow_step(following_, seen.sighting, options_->follower);
    count(seen);
    if (sender_) sender_->send(following_);
    const FollowedPicture picture{seen.source.index, seen.source.name, seen.lines.confidence, following_};
    if (by_hand_) by_hand_->add(picture, options_->follower.is_metric);
    if (files_) FURROW_DO(files_->add(picture, std::move(seen)));
    return !options_->on_picture || options_->on_picture(picture);
  }

  Result<FollowOutcome> finish() {
    if (sender_ && sender_->link().dropped() > 0) {
      outcome_.notes.push_back(std::to_string(sender_->link().dropped()) + " of " +
                               std::to_string(sender_->link().dropped() + sender_->link().sent()) +
                               " steering frames could not be sent");
    }
    if (files_) {
      FURROW_TRY(outcome_.files, files_->finish());
    }
    if (by_hand_) FURROW_DO(compare_by_hand());
    return std::move(outcome_);
  }

 private:
  void count(const SeenPicture& seen) {
    const bool is_first_start = following_.event == follow::RowEvent::started && following_.count == 0;
    outcome_.row_changes += following_.event != follow::RowEvent::none && !is_first_start ? 1 : 0;
    outcome_.seen += seen.lines.ok() ? 1 : 0;
    outcome_.held += following_.is_hold ? 1 : 0;
    ++outcome_.pictures;
  }

  Status compare_by_hand() {
    outcome_.by_hand = by_hand_table(by_hand_->flights());
    if (by_hand_->missing() > 0)
      outcome_.notes.push_back(options_->by_hand->filename().string() + ": " +
                               std::to_string(by_hand_->missing()) +
                               " pictures read by hand are not in the source");
    if (!options_->out) return Done{};
    FURROW_DO(base::write_file(*options_->out / "by_hand.csv", base::to_csv(outcome_.by_hand)));
    outcome_.files.push_back("by_hand.csv");
    FURROW_TRY(const figures::Figure figure, figures::deviation_by_hand(by_hand_->flights()));
    FURROW_DO(figures::write_figure(*options_->out / "figures", figure));
    outcome_.files.push_back("figures/" + figure.name + ".png");
    return Done{};
  }

  const FollowJobOptions* options_;
  follow::Following following_;
  std::optional<ByHand> by_hand_;
  std::optional<SteeringSender> sender_;
  std::optional<FollowFiles> files_;
  FollowOutcome outcome_;
};

/// A batch through the lanes, each of which works through its own pictures in order.
std::vector<SeenPicture> look_at(std::vector<image::TimedPicture> pictures, std::vector<Lane>& lanes,
                                 int threads) {
  std::vector<SeenPicture> seen(pictures.size());
  base::parallel_for(lanes.size(), threads, [&](std::size_t lane) {
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      if (static_cast<std::size_t>(pictures[i].index) % lanes.size() == lane)
        seen[i] = lanes[lane].look(std::move(pictures[i]));
    }
  });
  return seen;
}

}  // namespace

Result<FollowOutcome> follow_job(std::unique_ptr<image::PictureSource> source,
                                 const FollowJobOptions& options) {
  constexpr std::size_t kBatch = 2 * kLanes;
  PictureQueue queue(std::move(source), options.silence_s, options.stop);
  Sequence sequence(options);
  FURROW_DO(sequence.open(queue.info().nominal_rate_hz));
  std::vector<Lane> lanes(kLanes, Lane(options));
  bool goes_on = true;
  while (goes_on) {
    std::vector<image::TimedPicture> pictures = queue.take(kBatch);
    if (pictures.empty()) break;
    for (SeenPicture& seen : look_at(std::move(pictures), lanes, options.threads)) {
      FURROW_TRY(goes_on, sequence.add(std::move(seen)));
      if (!goes_on) break;
    }
  }
  FURROW_TRY(FollowOutcome outcome, sequence.finish());
  for (const std::string& trouble : queue.trouble()) outcome.notes.push_back(trouble);
  outcome.skipped = queue.skipped();
  outcome.source_failed = queue.failed();
  return outcome;
}

}  // namespace furrow::project
