#include "common/app/answer.h"

#include <exception>
#include <utility>

#include "common/bus/channels.h"
#include "common/messages/codec.h"
#include "common/messages/preview.h"

namespace sprout {
namespace {

float CoverageOf(const Frame& frame, const StageResult& result) {
  const SeedSet* seeds = frame.seeds ? &*frame.seeds : nullptr;
  for (const PartOutput& output : result.outputs) {
    if (output.part == Part::kSeeds) seeds = &std::get<SeedSet>(output.value);
  }
  const std::optional<cv::Size> size = ImageSize(frame);
  return seeds && size ? TofCoverage(seeds->seeds, *size) : kUnknownCoverage;
}

}  // namespace

DisparityEncoding EncodingOf(const BusConfig& config) {
  return config.disparity_encoding() == BusConfig::DELTA_ZSTD ? DisparityEncoding::kDeltaZstd
                                                              : DisparityEncoding::kRawInt16;
}

std::optional<Answer> MakeAnswer(const Frame& frame, StageAdapter& adapter,
                                 DisparityEncoding encoding, StageMonitor& monitor) {
  try {
    StageResult result = adapter.Process(frame);
    Answer answer;
    for (const PartOutput& output : result.outputs) {
      answer.messages.push_back(
          {ChannelOf(output.part), EncodePart(frame.id, output.part, output.value, encoding)});
    }
    if (!result.preview.empty()) {
      answer.messages.push_back({kPreviewChannel, EncodePreview(frame.id, result.preview)});
    }
    if (result.scan) {
      answer.messages.push_back({kScanChannel, EncodeScan(frame.id, *result.scan)});
    }
    answer.tof_coverage = CoverageOf(frame, result);
    answer.tof_offset = result.tof_offset;
    answer.finding = std::move(result.finding);
    answer.degenerate = std::move(result.degenerate);
    return answer;
  } catch (const std::exception& e) {
    monitor.FrameFailed(frame.id, e.what());
    return std::nullopt;
  }
}

}  // namespace sprout
