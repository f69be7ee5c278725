#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "services/view/decoded_frame.h"
#include "services/view/frame_source.h"
#include "services/view/map_colors.h"
#include "services/view/packet.h"

namespace sprout::view {

/// Pictures of a frame.
enum class Picture {
  kLeft,
  kTof,
  kDisparity,
  kDepth,
  kPrior,
  kSigma,  ///< of the prior
  kConfidence,
  kDisparitySigma,
  kFused,
  kFusedDepth
};
inline constexpr int kPictureCount = static_cast<int>(Picture::kFusedDepth) + 1;

/// The page's name of a picture ("left", "tof", ...), and back; nothing for another name.
std::string_view NameOf(Picture picture);
std::optional<Picture> PictureOf(std::string_view name);

/// What a page shows of a frame.
struct ShownParts {
  std::vector<std::pair<Picture, int>> pictures;  ///< with the most columns, px
  bool cloud = false;
  bool seeds = false;
};

/// Encodes stored frames for pages. Works only on demand, and only once if several pages ask for
/// the same: the newest decoded frames and finished pictures are kept. Thread-safe; processes one
/// frame at a time.
class FrameEncoder {
 public:
  /// @param complain  called for parts that cannot be decoded.
  explicit FrameEncoder(DecodedFrame::Complain complain) : complain_(std::move(complain)) {}

  /// The packet of a frame: head {type: "frame", key, version, seq, utime, width, height, scales:
  /// {disparity: {min, max}, ...}, keys, channels: of its messages, parts}. Missing parts are left
  /// out.
  /// @param keys  of the frames that the page can ask for; goes into the head.
  std::string Encode(const StoredFramePtr& frame, const ShownParts& shown, const KeyRange& keys);

  /// A single picture; null when the frame does not have it.
  EncodedPartPtr EncodePicture(const StoredFramePtr& frame, Picture picture, int width);

  nlohmann::json Probe(const StoredFramePtr& frame, int u, int v);

  /// A decoded frame, to be saved.
  std::shared_ptr<DecodedFrame> Decode(const StoredFramePtr& frame);

 private:
  struct CachedPart {
    int64_t key;
    int64_t version;
    std::string what;
    EncodedPartPtr part;
  };

  template <typename Make>
  EncodedPartPtr Cached(const StoredFrame& frame, const std::string& what, const Make& make);
  struct Drawing;
  std::optional<Drawing> Draw(DecodedFrame& frame, Picture picture, int width) const;
  EncodedPartPtr MakePicture(DecodedFrame& frame, Picture picture, int width) const;
  void FollowRanges(DecodedFrame& frame);

  DecodedFrame::Complain complain_;
  std::mutex mutex_;
  std::deque<std::shared_ptr<DecodedFrame>> decoded_;  // newest last
  std::deque<CachedPart> cache_;                       // newest last
  size_t cache_bytes_ = 0;
  StableRange calm_disparity_;
  StableRange calm_depth_;
  ValueRange disparity_px_;
  ValueRange depth_m_{.min = 0.1, .max = 1};  // min > 0, since colours go by 1/depth
};

}  // namespace sprout::view
