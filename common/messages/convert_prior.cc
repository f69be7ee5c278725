#include <cstdint>
#include <cstring>
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <vector>

#include "common/core/checks.h"
#include "common/core/result.h"
#include "common/messages/compressor.h"
#include "common/messages/convert.h"
#include "common/messages/disparity_codec.h"

namespace sprout {
namespace {

size_t SigmaBytes(cv::Size size) {
  return static_cast<size_t>(size.width) * static_cast<size_t>(size.height);
}

// The encodings of the standard deviations in lcmtypes/prior_t.lcm, counts as in PriorMap, besides
// BytesOf(), and the inverse of both; an error when `data` is not exactly one map of `size`.
Result<cv::Mat1b> DecodeSigmaRaw(std::span<const uint8_t> data, cv::Size size) {
  if (data.size() != SigmaBytes(size)) {
    return Fail("sigma_size = " + std::to_string(data.size()) +
                ": allowed is width × height = " + std::to_string(SigmaBytes(size)));
  }
  cv::Mat1b sigma(size);
  std::memcpy(sigma.data, data.data(), data.size());
  return sigma;
}

std::vector<uint8_t> EncodeSigmaDeltaZstd(const cv::Mat1b& sigma) {
  std::vector<uint8_t> deltas(SigmaBytes(sigma.size()));
  size_t i = 0;
  for (int v = 0; v < sigma.rows; ++v) {
    const uint8_t* const row = sigma[v];
    uint8_t left = 0;
    for (int u = 0; u < sigma.cols; ++u, ++i) {
      deltas[i] = static_cast<uint8_t>(row[u] - left);
      left = row[u];
    }
  }
  return CompressZstd(deltas);
}

Result<cv::Mat1b> DecodeSigmaDeltaZstd(std::span<const uint8_t> data, cv::Size size) {
  const auto deltas = DecompressZstd(data, SigmaBytes(size), "sigma", "width × height");
  if (!deltas) return tl::unexpected(deltas.error());
  cv::Mat1b sigma(size);
  size_t i = 0;
  for (int v = 0; v < size.height; ++v) {
    uint8_t* const row = sigma[v];
    uint8_t left = 0;
    for (int u = 0; u < size.width; ++u, ++i)
      row[u] = left = static_cast<uint8_t>(left + (*deltas)[i]);
  }
  return sigma;
}

// How sure a disparity is must be said by 1 to 255 counts, and where there is none by 255: a stage
// divides by it.
Result<void> CheckSigma(const DisparityImage& disparity, const cv::Mat1b& sigma) {
  for (int v = 0; v < sigma.rows; ++v) {
    const int16_t* const disparities = disparity.counts()[v];
    const uint8_t* const sigmas = sigma[v];
    int bad = 0;
    for (int u = 0; u < sigma.cols; ++u) {
      const uint8_t least = disparities[u] == DisparityImage::kInvalid ? kMaxSigmaCounts : 1;
      bad += sigmas[u] < least ? 1 : 0;
    }
    if (bad == 0) continue;
    for (int u = 0; u < sigma.cols; ++u) {
      const bool valid = disparity.IsValid(u, v);
      if (sigmas[u] >= (valid ? 1 : kMaxSigmaCounts)) continue;
      return Fail("sigma at (" + std::to_string(u) + ", " + std::to_string(v) +
                  ") = " + std::to_string(sigmas[u]) + ": allowed is " +
                  (valid ? "1 to 255" : "255 where there is no disparity"));
    }
  }
  return {};
}

Result<PriorMap> Decode(const prior_t& message) {
  const cv::Size size(message.width, message.height);
  const bool raw = message.encoding == prior_t::ENCODING_RAW;
  Result<DisparityImage> disparity =
      raw ? DecodeRawInt16(message.data, size) : DecodeDeltaZstd(message.data, size);
  if (!disparity) return tl::unexpected(disparity.error());
  Result<cv::Mat1b> sigma =
      raw ? DecodeSigmaRaw(message.sigma, size) : DecodeSigmaDeltaZstd(message.sigma, size);
  if (!sigma) return tl::unexpected(sigma.error());
  return PriorMap(std::move(*disparity), std::move(*sigma));
}

}  // namespace

prior_t ToMessage(const FrameId& id, const PriorMap& prior, DisparityEncoding encoding) {
  CV_Assert(prior.sigma.size() == prior.size());
  prior_t message;
  message.header = ToMessage(id);
  message.width = prior.disparity.width();
  message.height = prior.disparity.height();
  message.counts_per_px = DisparityImage::kCountsPerPixel;
  message.invalid = DisparityImage::kInvalid;
  message.sigma_counts_per_px = kSigmaCountsPerPx;
  switch (encoding) {
    case DisparityEncoding::kRawInt16:
      message.encoding = prior_t::ENCODING_RAW;
      message.data = BytesOf(prior.disparity.counts());
      message.sigma = BytesOf(prior.sigma);
      break;
    case DisparityEncoding::kDeltaZstd:
      message.encoding = prior_t::ENCODING_DELTA_ZSTD;
      message.data = EncodeDeltaZstd(prior.disparity);
      message.sigma = EncodeSigmaDeltaZstd(prior.sigma);
      break;
  }
  message.size = static_cast<int32_t>(message.data.size());
  message.sigma_size = static_cast<int32_t>(message.sigma.size());
  return message;
}

Result<PriorMap> FromMessage(const prior_t& message) {
  Checks checks;
  checks.DisparityMap(message, message.data.size())
      .Require(message.sigma_counts_per_px == kSigmaCountsPerPx, "sigma_counts_per_px",
               message.sigma_counts_per_px, std::to_string(kSigmaCountsPerPx))
      .Require(message.sigma_size >= 0 &&
                   static_cast<size_t>(message.sigma_size) == message.sigma.size(),
               "sigma_size", message.sigma_size, "the number of bytes in sigma")
      .Require(message.encoding == prior_t::ENCODING_RAW ||
                   message.encoding == prior_t::ENCODING_DELTA_ZSTD,
               "encoding", message.encoding, "RAW or DELTA_ZSTD");
  if (!checks.ok()) return checks.error();
  Result<PriorMap> prior = Decode(message);
  if (!prior) return prior;
  if (const Result<void> sigma = CheckSigma(prior->disparity, prior->sigma); !sigma) {
    return tl::unexpected(sigma.error());
  }
  return prior;
}

}  // namespace sprout
