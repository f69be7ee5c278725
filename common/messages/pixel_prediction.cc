#include "common/messages/pixel_prediction.h"

#include <algorithm>
#include <cassert>

namespace sprout {
namespace {

constexpr uint8_t kMiddle = 128;

// Most that the neighbours of a pixel of each class but the last differ.
constexpr std::array<uint8_t, kPixelClasses - 1> kMaxDifference = {3, 8, 20};

struct Prediction {
  uint8_t pixel;
  uint8_t pixel_class;
};

// Predicts a pixel from the neighbours to the left, above, and above left. In single bytes and
// without branches, so that the compiler makes vectors of it, and nothing is guessed wrong where it
// cannot.
inline Prediction PredictFrom(uint8_t a, uint8_t b, uint8_t c) {
  const uint8_t low = std::min(a, b);
  const uint8_t high = std::max(a, b);
  // The median of a, b and a + b - c.
  const auto pixel = static_cast<uint8_t>(a + b - std::max(low, std::min(high, c)));
  const auto difference = static_cast<uint8_t>(std::max(high, c) - std::min(low, c));
  return {pixel, static_cast<uint8_t>((difference > kMaxDifference[0] ? 1 : 0) +
                                      (difference > kMaxDifference[1] ? 1 : 0) +
                                      (difference > kMaxDifference[2] ? 1 : 0))};
}

// A row of one channel, with the pixel above its first one in front of it.
using Line = std::vector<uint8_t>;

void TakeRow(const uint8_t* pixels, size_t width, std::span<Line> lines) {
  if (lines.size() == 1) {
    std::copy_n(pixels, width, lines[0].data() + 1);
    return;
  }
  uint8_t* const first = lines[0].data() + 1;
  uint8_t* const second = lines[1].data() + 1;
  uint8_t* const third = lines[2].data() + 1;
  for (size_t u = 0; u < width; ++u) {
    const uint8_t green = pixels[3 * u + 1];
    first[u] = static_cast<uint8_t>(pixels[3 * u] - green + kMiddle);
    second[u] = green;
    third[u] = static_cast<uint8_t>(pixels[3 * u + 2] - green + kMiddle);
  }
}

void GiveRow(std::span<const Line> lines, size_t width, uint8_t* pixels) {
  if (lines.size() == 1) {
    std::copy_n(lines[0].data() + 1, width, pixels);
    return;
  }
  const uint8_t* const first = lines[0].data() + 1;
  const uint8_t* const second = lines[1].data() + 1;
  const uint8_t* const third = lines[2].data() + 1;
  for (size_t u = 0; u < width; ++u) {
    const uint8_t green = second[u];
    pixels[3 * u] = static_cast<uint8_t>(first[u] + green - kMiddle);
    pixels[3 * u + 1] = green;
    pixels[3 * u + 2] = static_cast<uint8_t>(third[u] + green - kMiddle);
  }
}

void PredictLine(const uint8_t* __restrict line, const uint8_t* __restrict above, size_t width,
                 uint8_t* __restrict errors, uint8_t* __restrict classes) {
  for (size_t u = 1; u <= width; ++u) {
    const Prediction predicted = PredictFrom(line[u - 1], above[u], above[u - 1]);
    errors[u - 1] = static_cast<uint8_t>(line[u] - predicted.pixel);
    classes[u - 1] = predicted.pixel_class;
  }
}

// Appends each error to those of its class: it is written behind all of them, and stays where an
// end moves on. A single one through a table of ends would wait for the one before to be stored.
void Deal(const Line& errors, const Line& classes, size_t width,
          std::array<uint8_t*, kPixelClasses>& ends) {
  std::array<uint8_t*, kPixelClasses> end = ends;
  for (size_t u = 0; u < width; ++u) {
    for (uint8_t k = 0; k < kPixelClasses; ++k) {
      *end[k] = errors[u];
      end[k] += classes[u] == k ? 1 : 0;
    }
  }
  ends = end;
}

// The pixel to the left of the first one counts as the one above that, in both rows.
void BeginLine(Line& line, Line& above) { line[0] = above[0] = above[1]; }

}  // namespace

void PixelPredictor::Reserve(size_t pixels, size_t channels) {
  if (pixels > reserved_) errors_.clear();
  reserved_ = std::max(reserved_, pixels);
  while (errors_.size() < channels * kPixelClasses) {
    errors_.push_back(std::make_unique_for_overwrite<uint8_t[]>(reserved_));
  }
}

std::vector<ClassedErrors> PixelPredictor::Predict(std::span<const uint8_t> pixels, size_t width,
                                                   size_t channels) {
  assert(channels == 1 || channels == 3);
  const size_t row_bytes = width * channels;
  Reserve(pixels.size() / channels, channels);
  std::vector<Line> lines(channels, Line(width + 1));
  std::vector<Line> above(channels, Line(width + 1));
  Line errors(width);
  Line classes(width);
  std::vector<std::array<uint8_t*, kPixelClasses>> ends(channels);
  for (size_t i = 0; i < channels * kPixelClasses; ++i) {
    ends[i / kPixelClasses][i % kPixelClasses] = errors_[i].get();
  }
  for (size_t at = 0; at < pixels.size(); at += row_bytes) {
    TakeRow(&pixels[at], width, lines);
    for (size_t channel = 0; channel < channels; ++channel) {
      BeginLine(lines[channel], above[channel]);
      PredictLine(lines[channel].data(), above[channel].data(), width, errors.data(),
                  classes.data());
      Deal(errors, classes, width, ends[channel]);
    }
    lines.swap(above);
  }
  std::vector<ClassedErrors> classed(channels);
  for (size_t i = 0; i < channels * kPixelClasses; ++i) {
    const uint8_t* const begin = errors_[i].get();
    classed[i / kPixelClasses][i % kPixelClasses] = {
        begin, static_cast<size_t>(ends[i / kPixelClasses][i % kPixelClasses] - begin)};
  }
  return classed;
}

namespace {

// The errors of a channel that are not used yet.
struct ErrorReader {
  std::array<const uint8_t*, kPixelClasses> next{};
  std::array<const uint8_t*, kPixelClasses> end{};
};

// A row of every channel, pixel by pixel: each pixel waits for the one before it, but not for those
// of other channels.
template <size_t kChannels>
bool ReconstructRow(std::span<ErrorReader> readers, std::span<const Line> above, size_t width,
                    std::span<Line> lines) {
  std::array<ErrorReader, kChannels> reader;
  std::array<uint8_t, kChannels> left;
  for (size_t k = 0; k < kChannels; ++k) {
    reader[k] = readers[k];
    left[k] = lines[k][0];
  }
  for (size_t u = 1; u <= width; ++u) {
    for (size_t k = 0; k < kChannels; ++k) {
      const Prediction predicted = PredictFrom(left[k], above[k][u], above[k][u - 1]);
      const uint8_t*& error = reader[k].next[predicted.pixel_class];
      if (error == reader[k].end[predicted.pixel_class]) return false;
      left[k] = static_cast<uint8_t>(predicted.pixel + *error++);
      lines[k][u] = left[k];
    }
  }
  std::ranges::copy(reader, readers.begin());
  return true;
}

}  // namespace

bool Reconstruct(std::span<const ClassedErrors> errors, size_t width, std::span<uint8_t> pixels) {
  const size_t channels = errors.size();
  assert(channels == 1 || channels == 3);
  std::vector<Line> lines(channels, Line(width + 1));
  std::vector<Line> above(channels, Line(width + 1));
  std::vector<ErrorReader> readers(channels);
  for (size_t channel = 0; channel < channels; ++channel) {
    for (size_t k = 0; k < kPixelClasses; ++k) {
      const std::span<const uint8_t> all = errors[channel][k];
      readers[channel].next[k] = all.data();
      readers[channel].end[k] = all.data() + all.size();
    }
  }
  for (size_t at = 0; at < pixels.size(); at += width * channels) {
    for (size_t channel = 0; channel < channels; ++channel) {
      BeginLine(lines[channel], above[channel]);
    }
    const bool enough = channels == 1 ? ReconstructRow<1>(readers, above, width, lines)
                                      : ReconstructRow<3>(readers, above, width, lines);
    if (!enough) return false;
    GiveRow(lines, width, &pixels[at]);
    lines.swap(above);
  }
  return std::ranges::all_of(readers,
                             [](const ErrorReader& reader) { return reader.next == reader.end; });
}

}  // namespace sprout
