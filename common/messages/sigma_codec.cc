#include "common/messages/sigma_codec.h"

#include <cstring>
#include <string>

#include "common/messages/zstd_frame.h"

namespace sprout {
namespace {

size_t SigmaBytes(cv::Size size) {
  return static_cast<size_t>(size.width) * static_cast<size_t>(size.height);
}

}  // namespace

std::vector<uint8_t> EncodeSigmaRaw(const cv::Mat1b& sigma) {
  std::vector<uint8_t> data;
  data.reserve(SigmaBytes(sigma.size()));
  for (int v = 0; v < sigma.rows; ++v) data.insert(data.end(), sigma[v], sigma[v] + sigma.cols);
  return data;
}

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

}  // namespace sprout
