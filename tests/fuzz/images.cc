// Pictures from files, and payloads of cameras.
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "common/config/config_error.h"
#include "common/scenes/pfm.h"
#include "services/capture/genicam/pixels.h"
#include "services/capture/genicam/scan3d.h"
#include "tests/fuzz/targets.h"

namespace sprout::fuzz {
namespace {

constexpr capture::PixelFormat kFormats[] = {
    capture::PixelFormat::kMono8,        capture::PixelFormat::kMono16,
    capture::PixelFormat::kBayerGR8,     capture::PixelFormat::kBayerRG8,
    capture::PixelFormat::kBayerGB8,     capture::PixelFormat::kBayerBG8,
    capture::PixelFormat::kRGB8,         capture::PixelFormat::kBGR8,
    capture::PixelFormat::kCoord3dAbc16, capture::PixelFormat::kCoord3dAbc32f,
    capture::PixelFormat::kCoord3dC16,   capture::PixelFormat::kCoord3dC32f,
    capture::PixelFormat::kConfidence8,  capture::PixelFormat::kConfidence16};

capture::PayloadPart PartFrom(Reader& reader) {
  capture::PayloadPart part;
  const size_t format = reader.Byte();
  part.format = format < std::size(kFormats) ? static_cast<uint32_t>(kFormats[format]) : 1;
  part.width = static_cast<int16_t>(reader.Short());
  part.height = static_cast<int16_t>(reader.Short());
  part.row_padding = reader.Byte();
  part.content = static_cast<capture::PartContent>(reader.Byte() % 4);
  part.bytes = reader.Take(reader.Short());
  return part;
}

Bytes PayloadOf(size_t format, int width, int height, capture::PartContent content, size_t bytes) {
  Bytes payload = {static_cast<uint8_t>(format),
                   static_cast<uint8_t>(width),
                   0,
                   static_cast<uint8_t>(height),
                   0,
                   0,
                   static_cast<uint8_t>(content),
                   static_cast<uint8_t>(bytes),
                   0};
  for (size_t i = 0; i < bytes; ++i) payload.push_back(static_cast<uint8_t>(i));
  return payload;
}

}  // namespace

void ReadPfmFile(std::span<const uint8_t> bytes) {
  const MemoryFile file(bytes);
  try {
    const cv::Mat1f samples = scenes::ReadPfm(file.path());
    Check(4 * samples.total() <= bytes.size(), "more samples than bytes");
  } catch (const ConfigError&) {
  }
}

std::vector<Bytes> PfmSeeds() {
  const std::string samples(24, 'x');
  return {BytesOf("Pf\n3 2\n-0.003922\n" + samples), BytesOf("Pf\r\n2 3\r\n1\r\n" + samples)};
}

void ReadImageFile(std::span<const uint8_t> bytes) {
  const MemoryFile file(bytes);
  for (const int flags : {cv::IMREAD_COLOR, cv::IMREAD_UNCHANGED}) {
    try {
      Check(!scenes::ReadImage(file.path(), flags).empty(), "an image without a pixel");
    } catch (const ConfigError&) {
    }
  }
}

std::vector<Bytes> ImageSeeds() {
  std::vector<Bytes> seeds;
  const auto add = [&](const char* kind, int type, const std::vector<int>& flags = {}) {
    cv::Mat image(9, 13, type);
    cv::randu(image, 0, 256);
    cv::imencode(kind, image, seeds.emplace_back(), flags);
  };
  add(".png", CV_8UC1);
  add(".png", CV_8UC3);
  add(".png", CV_8UC4);
  add(".png", CV_16UC1);
  add(".jpg", CV_8UC1);
  add(".jpg", CV_8UC3);
  add(".jpg", CV_8UC3, {cv::IMWRITE_JPEG_PROGRESSIVE, 1});
  add(".ppm", CV_8UC3);
  add(".pgm", CV_8UC1);
  add(".pgm", CV_16UC1);
  add(".ppm", CV_8UC3, {cv::IMWRITE_PXM_BINARY, 0});
  return seeds;
}

void ReadPayload(std::span<const uint8_t> bytes) {
  Reader reader(bytes);
  const capture::PayloadPart parts[] = {PartFrom(reader), PartFrom(reader)};
  if (const Result<cv::Mat> image = capture::ToImage(parts[0])) {
    Check(image->size() == cv::Size(parts[0].width, parts[0].height), "an image of another size");
  }
  for (const size_t count : {size_t{1}, size_t{2}}) {
    const Result<TofImage> tof =
        capture::ToTofImage(std::span(parts).first(count), {.invalid = 0, .is_range = true});
    if (tof && !tof->amplitude.empty()) {
      Check(tof->amplitude.size() == tof->depth_m.size(), "an amplitude of another size");
    }
  }
}

std::vector<Bytes> PayloadSeeds() {
  constexpr int kBytesPerPixel[] = {1, 2, 1, 1, 1, 1, 3, 3, 6, 12, 2, 4, 1, 2};
  std::vector<Bytes> seeds;
  for (size_t format = 0; format < std::size(kFormats); ++format) {
    const auto bytes = static_cast<size_t>(4 * 3 * kBytesPerPixel[format]);
    seeds.push_back(PayloadOf(format, 4, 3, capture::PartContent::kUnknown, bytes));
    Bytes range = PayloadOf(10, 4, 3, capture::PartContent::kRange, 24);
    const Bytes other = PayloadOf(format, 4, 3, capture::PartContent::kConfidence, bytes);
    range.insert(range.end(), other.begin(), other.end());
    seeds.push_back(range);
  }
  return seeds;
}

}  // namespace sprout::fuzz
