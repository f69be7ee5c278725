#include "services/capture/image_encoder.h"

#include <optional>
#include <utility>

#include "common/core/parallel.h"

namespace sprout::capture {
namespace {

std::optional<int> QualityOf(const CaptureConfig& config) {
  if (config.image_encoding() != CaptureConfig::JPEG) return std::nullopt;
  return config.jpeg_quality();
}

}  // namespace

ImageEncoder::ImageEncoder(const CaptureConfig& config)
    : left_(QualityOf(config)), right_(QualityOf(config)) {}

void ImageEncoder::Encode(CaptureMessages& frame) {
  const auto encode = [&frame](Part image, MessageCompressor& compressor) {
    for (auto& [part, bytes] : frame.messages) {
      if (part != image) continue;
      if (auto smaller = compressor.Compress(ChannelOf(part), bytes)) bytes = *std::move(smaller);
    }
  };
  RunBoth([&] { encode(Part::kLeft, left_); }, [&] { encode(Part::kRight, right_); });
}

}  // namespace sprout::capture
