#include "services/capture/triplet_synchronizer.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

namespace sprout::capture {
namespace {

// Bounds the memory: at most so many images of a camera wait, whatever their times are.
constexpr size_t kMaxWaitingImages = 64;

Triplet Taken(std::deque<TimedImage>& left, std::deque<TimedImage>& right) {
  Triplet triplet{.left = std::move(left.front()), .right = std::move(right.front()), .tof = {}};
  left.pop_front();
  right.pop_front();
  return triplet;
}

// Whether the second image of a queue is closer to a time than the first.
bool SecondIsCloser(const std::deque<TimedImage>& queue, int64_t utime) {
  return queue.size() > 1 && std::abs(queue[1].utime - utime) < std::abs(queue[0].utime - utime);
}

}  // namespace

std::string JoinTrouble(const TofJoins& joins, const TripletConfig& config,
                        const std::string& sensor, bool at_end) {
  if (!config.has_tof) return {};
  int64_t power = 10;
  while (power < joins.pairs_since_join) power *= 10;
  const int64_t most = std::max<int64_t>(std::min(joins.came, joins.pairs), 1);
  const bool is_due = at_end ? 3 * joins.joined < 2 * most && joins.pairs > 0
                             : joins.pairs_since_join == power && power > 2 * joins.longest_gap;
  if (!is_due) return {};
  if (joins.came == 0) {
    return fmt::format("no range image came with {} pairs: does {} send any?", joins.pairs, sensor);
  }
  std::string text = fmt::format("{} of {} range images of {} joined {} pairs", joins.joined,
                                 joins.came, sensor, joins.pairs);
  if (joins.pairs_since_join > 0) text += fmt::format(", none the last {}", joins.pairs_since_join);
  if (joins.nearest_us) {
    const double distance_ms = static_cast<double>(*joins.nearest_us) / 1000;
    text += fmt::format(": the nearest is {:+.1f} ms off, max_spread_ms is {:g}", distance_ms,
                        static_cast<double>(config.max_spread_us) / 1000);
    constexpr double kOtherClockMs = 10'000;
    if (std::abs(distance_ms) > kOtherClockMs) {
      text += "; is that another clock, or are there no stamps?";
    }
  } else if (joins.joined == 0) {
    text += ": all came before or after the images; allowed is one clock of all recordings";
  }
  return text;
}

double Triplet::spread_ms() const {
  int64_t first = std::min(left.utime, right.utime);
  int64_t last = std::max(left.utime, right.utime);
  if (tof) {
    first = std::min(first, tof->utime);
    last = std::max(last, tof->utime);
  }
  return static_cast<double>(last - first) * 1e-3;
}

void TripletSynchronizer::DropFront(RigPlace place) {
  QueueOf(place).pop_front();
  ++unpaired_[Index(place)];
}

void TripletSynchronizer::Drop(RigPlace place) {
  while (!QueueOf(place).empty()) DropFront(place);
}

void TripletSynchronizer::Push(RigPlace place, TimedImage image) {
  Queue& queue = QueueOf(place);
  if (place == RigPlace::kTof) {
    tof_is_silent_ = false;
    ++joins_.came;
  }
  if (!queue.empty() && image.utime < queue.back().utime) Drop(place);
  if (queue.size() == kMaxWaitingImages) DropFront(place);
  Pace& pace = paces_[Index(place)];
  if (image.utime > pace.newest) pace.steps = {pace.steps[1], image.utime - pace.newest};
  pace.newest = image.utime;
  queue.push_back(std::move(image));
}

std::optional<Triplet> TripletSynchronizer::Next(int64_t now_utime) {
  if (FindPair(now_utime)) {
    Queue& tofs = QueueOf(RigPlace::kTof);
    switch (FindTof(now_utime)) {
      case Search::kWait:
        return std::nullopt;
      case Search::kNone:
        NoteOverdue();
        ++joins_.pairs;
        ++joins_.pairs_since_join;
        return Taken(QueueOf(RigPlace::kLeft), QueueOf(RigPlace::kRight));
      case Search::kFound: {
        Triplet triplet = Taken(QueueOf(RigPlace::kLeft), QueueOf(RigPlace::kRight));
        triplet.tof = std::move(tofs.front());
        tofs.pop_front();
        ++joins_.pairs;
        ++joins_.joined;
        joins_.longest_gap = std::max(joins_.longest_gap, joins_.pairs_since_join);
        joins_.pairs_since_join = 0;
        return triplet;
      }
    }
  }
  DropOverdue(now_utime);
  return std::nullopt;
}

void TripletSynchronizer::DropOverdue(int64_t now_utime) {
  for (const RigPlace place : kRigPlaces) {
    const Queue& queue = QueueOf(place);
    while (!queue.empty() && queue.front().utime + config_.max_wait_us < now_utime) {
      if (place == RigPlace::kTof) overdue_tof_utime_ = queue.front().utime;
      DropFront(place);
    }
  }
}

// Whether the first image that waits has no partner at a later time: it is too early, or another
// one is closer, or would be, had it not been lost.
bool TripletSynchronizer::IsAlone(RigPlace place, int64_t utime) const {
  const Queue& queue = queues_[Index(place)];
  const int64_t early = utime - queue.front().utime;
  return early > config_.max_spread_us || SecondIsCloser(queue, utime) ||
         4 * early > 3 * std::ranges::max(paces_[Index(place)].steps);
}

// Whether an image that is closer to a later time than the one that waits is still to come. Without
// this a lost image would shift all pairs behind it, of cameras so fast that a neighbour is near.
bool TripletSynchronizer::CloserMayCome(RigPlace place, int64_t utime, int64_t now_utime) const {
  const Queue& queue = queues_[Index(place)];
  const int64_t first = queue.front().utime;
  return queue.size() == 1 && first + config_.max_wait_us >= now_utime &&
         2 * (utime - first) > std::ranges::min(paces_[Index(place)].steps);
}

// True when the fronts of both queues belong together. Drops what has no partner on the way.
bool TripletSynchronizer::FindPair(int64_t now_utime) {
  const Queue& lefts = QueueOf(RigPlace::kLeft);
  const Queue& rights = QueueOf(RigPlace::kRight);
  while (!lefts.empty() && !rights.empty()) {
    const int64_t left = lefts.front().utime;
    const int64_t right = rights.front().utime;
    const RigPlace earlier = left < right ? RigPlace::kLeft : RigPlace::kRight;
    const int64_t later = std::max(left, right);
    if (!IsAlone(earlier, later)) return !CloserMayCome(earlier, later, now_utime);
    DropFront(earlier);
  }
  return false;
}

void TripletSynchronizer::NoteDistance(int64_t tof_utime, int64_t pair_utime) {
  const int64_t distance = tof_utime - pair_utime;
  if (!joins_.nearest_us || std::abs(distance) < std::abs(*joins_.nearest_us)) {
    joins_.nearest_us = distance;
  }
}

// When the ToF camera's clock is behind, its images are overdue before their pair comes.
void TripletSynchronizer::NoteOverdue() {
  if (!overdue_tof_utime_) return;
  const int64_t left = QueueOf(RigPlace::kLeft).front().utime;
  const int64_t right = QueueOf(RigPlace::kRight).front().utime;
  NoteDistance(*std::exchange(overdue_tof_utime_, std::nullopt), left + (right - left) / 2);
}

// Whether the front of the ToF queue belongs to the pair in front of the others.
TripletSynchronizer::Search TripletSynchronizer::FindTof(int64_t now_utime) {
  if (!config_.has_tof) return Search::kNone;
  const int64_t left = QueueOf(RigPlace::kLeft).front().utime;
  const int64_t right = QueueOf(RigPlace::kRight).front().utime;
  const int64_t earliest = std::max(left, right) - config_.max_spread_us;
  const int64_t latest = std::min(left, right) + config_.max_spread_us;
  const int64_t middle = left + (right - left) / 2;
  const Queue& tofs = QueueOf(RigPlace::kTof);
  while (!tofs.empty()) {
    const int64_t tof = tofs.front().utime;
    if (tof > latest) {
      NoteDistance(tof, middle);
      return Search::kNone;
    }
    if (tof < earliest) NoteDistance(tof, middle);
    if (tof >= earliest && !(tof < middle && SecondIsCloser(tofs, middle))) {
      if (tof > middle && SecondIsCloser(QueueOf(RigPlace::kLeft), tof)) return Search::kNone;
      const bool may_be_closer = tof < middle ? CloserMayCome(RigPlace::kTof, middle, now_utime)
                                              : CloserMayCome(RigPlace::kLeft, tof, now_utime);
      return may_be_closer ? Search::kWait : Search::kFound;
    }
    DropFront(RigPlace::kTof);
  }
  if (std::max(left, right) + config_.max_wait_us < now_utime) tof_is_silent_ = true;
  return tof_is_there_ && !tof_is_silent_ ? Search::kWait : Search::kNone;
}

}  // namespace sprout::capture
