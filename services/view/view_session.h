#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/core/result.h"
#include "common/measure/target_meter.h"
#include "services/view/decoded_frame.h"
#include "services/view/frame_encoder.h"
#include "services/view/frame_source.h"

namespace sprout::view {

/// Measures a flat target in the frames that a page is shown, as sprout-quality does. All frames
/// have the calibration of the first one; with another it begins anew. For one thread.
class TargetPanel {
 public:
  /// Memory for the depths of one page, bytes: the more pixels, the fewer frames.
  static constexpr size_t kMaxBytes = size_t{64} << 20;
  static constexpr size_t kMaxFrames = 40;

  /// @param settings  `count` is replaced.
  explicit TargetPanel(TargetSettings settings) : settings_(std::move(settings)) {}

  /// The figures with this frame, which is added unless it was before: {region: [left,
  /// top, width, height], edge, frames, figures: [{name, title, text, meaning}]} or {error: why}.
  /// O(pixels of the region · frames).
  nlohmann::json Show(DecodedFrame& frame);

 private:
  Result<void> Begin(const Rig& rig, cv::Size size);
  nlohmann::json Figures() const;

  TargetSettings settings_;
  std::optional<TargetMeter> meter_;
  std::string rig_id_;
  std::deque<int64_t> keys_;  // of the frames in the meter
};

/// Memory for frames that all paused pages together may keep. Not thread-safe.
class PausedFrameBudget {
 public:
  explicit PausedFrameBudget(size_t bytes) : left_(bytes) {}

  bool Take(size_t bytes) {
    if (bytes > left_) return false;
    left_ -= bytes;
    return true;
  }
  void Give(size_t bytes) { left_ += bytes; }

 private:
  size_t left_;
};

/// The state of one page, without a socket. The page says what it wants to show, follows the graph
/// or shows single frames, and says when it has drawn one; only then it gets the newest. So a slow
/// page gets fewer frames, and nothing waits for it. Not thread-safe.
///
/// Messages of the page, JSON:
///   {"type": "wish", "pictures": {"left": 640, ...}, "cloud": true, "seeds": true}
///   {"type": "live"}           follow the graph (of a log: look at its last frame)
///   {"type": "pause"}          keep what is there, and stay
///   {"type": "look", "key": K} look at frame K, and stay
///   {"type": "drawn"}          ready for another frame
///   {"type": "probe", "u": U, "v": V}  what is known of a pixel of the frame on show
///   {"type": "measure", "region": [LEFT, TOP, WIDTH, HEIGHT], "edge": [...], "distance_m": D}
///                              measure a flat target in what is shown from now on, see
///                              TargetPanel; all three may be left out
///   {"type": "measure", "off": true}
class ViewSession {
 public:
  ViewSession(const FrameSource& source, PausedFrameBudget& budget)
      : source_(source), budget_(budget) {}
  ~ViewSession() { Release(); }
  ViewSession(const ViewSession&) = delete;
  ViewSession& operator=(const ViewSession&) = delete;

  /// @returns an error for any other message; then the connection is closed.
  Result<void> OnMessage(std::string_view text);

  /// The frame to send now, if any; the page must draw it before the next.
  struct Show {
    StoredFramePtr frame;
    ShownParts parts;
  };
  std::optional<Show> TakeFrame();

  /// The pixel to report now, if one was asked for: of several the last.
  struct Probe {
    StoredFramePtr frame;
    int u;
    int v;
  };
  std::optional<Probe> TakeProbe();

  /// What to measure now: once for each frame that was sent, and for each new region.
  struct Measure {
    StoredFramePtr frame;
    std::shared_ptr<TargetPanel> panel;
  };
  std::optional<Measure> TakeMeasure();

  /// A frame that the page asked for and that no longer exists; reported once.
  std::optional<int64_t> TakeGone() { return std::exchange(gone_, std::nullopt); }

  /// Frames that the page can show.
  KeyRange keys() const;

 private:
  Result<void> OnMeasure(const nlohmann::json& message);
  StoredFramePtr Wanted();
  StoredFramePtr Find(int64_t key) const;
  void Keep();
  void Release();

  const FrameSource& source_;
  PausedFrameBudget& budget_;
  ShownParts parts_;
  bool wish_changed_ = false;
  bool live_ = true;
  std::optional<int64_t> look_;  // key
  bool drawing_ = false;
  StoredFramePtr shown_;
  std::optional<std::pair<int, int>> probe_;
  std::shared_ptr<TargetPanel> panel_;
  bool to_measure_ = false;
  std::optional<int64_t> gone_;
  std::vector<StoredFramePtr> kept_;  // by key
  size_t kept_bytes_ = 0;
};

}  // namespace sprout::view
