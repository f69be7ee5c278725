#pragma once

#include "common/config/config.h"
#include "common/messages/compressor.h"
#include "services/capture/capture_feed.h"

namespace sprout::capture {

/// Makes the images of a frame smaller before they are sent, left and right at the same time.
class ImageEncoder {
 public:
  /// @pre config.image_encoding() is not RAW.
  explicit ImageEncoder(const CaptureConfig& config);

  /// Replaces the messages of LEFT and RIGHT where that makes them smaller.
  void Encode(CaptureMessages& frame);

 private:
  MessageCompressor left_;
  MessageCompressor right_;
};

}  // namespace sprout::capture
