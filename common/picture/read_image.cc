#include "common/picture/read_image.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "common/core/image.h"
#include "common/core/input_files.h"
#include "common/core/read_text.h"

namespace sprout {
namespace {

constexpr std::array<const char*, 5> kNames = {"PNG", "JPEG", "PPM", "BMP", "TIFF"};

struct Header {
  ImageFormat format;
  int64_t width = 0;  // 0: the header is damaged
  int64_t height = 0;
  bool has_more_pages = false;
  int64_t largest = 0;  // value of a pixel; 0: the format does not say
};

// The bytes of a file, anywhere; behind its end there is 0.
class FileBytes {
 public:
  explicit FileBytes(const std::filesystem::path& path) : file_(path, std::ios::binary) {}

  std::string At(int64_t offset, size_t count) {
    std::string bytes(count, '\0');
    file_.clear();
    file_.seekg(offset);
    file_.read(bytes.data(), static_cast<std::streamsize>(count));
    return bytes;
  }

  int64_t Number(int64_t offset, size_t count, bool little_endian) {
    std::string bytes = At(offset, count);
    if (little_endian) std::ranges::reverse(bytes);
    int64_t number = 0;
    for (const char byte : bytes) number = 256 * number + static_cast<uint8_t>(byte);
    return number;
  }

 private:
  std::ifstream file_;
};

// Segments up to the one with the size (SOF, ITU T.81, B.2.2).
void ReadJpeg(FileBytes& file, Header& header) {
  constexpr int kMaxSegments = 10'000;
  int64_t at = 2;
  for (int i = 0; i < kMaxSegments; ++i) {
    for (; i < kMaxSegments && file.Number(at, 2, false) == 0xffff; ++i) ++at;  // fill bytes
    const int64_t marker = file.Number(at, 2, false);
    const bool is_frame = marker >= 0xffc0 && marker <= 0xffcf && marker != 0xffc4 &&
                          marker != 0xffc8 && marker != 0xffcc;
    if (is_frame) {
      header.height = file.Number(at + 5, 2, false);
      header.width = file.Number(at + 7, 2, false);
      return;
    }
    if (marker < 0xffc0 || marker == 0xffd9 || marker == 0xffda) return;
    const bool is_bare = marker >= 0xffd0 && marker <= 0xffd8;
    at += is_bare ? 2 : 2 + file.Number(at + 2, 2, false);
  }
}

// Whether a JPEG has its end-of-image marker (EOI, ITU T.81, B.1.1.3). A file that was cut has
// none, and the decoder would fill what is missing. Bytes behind the marker are allowed.
bool HasJpegEnd(const std::filesystem::path& path) {
  constexpr int kEnd = std::filebuf::traits_type::eof();
  std::filebuf file;
  if (file.open(path, std::ios::in | std::ios::binary) == nullptr) return false;
  for (int byte = file.sbumpc(); byte != kEnd; byte = file.sbumpc()) {
    if (byte != 0xff) continue;  // of the entropy-coded data
    while (byte == 0xff) byte = file.sbumpc();
    if (byte == 0xd9) return true;
    const bool is_bare = byte <= 0x01 || (byte >= 0xd0 && byte <= 0xd8);
    if (is_bare) continue;  // or a byte 0xff of the data, or the end of the file
    // A segment may hold a thumbnail with an end of its own.
    const int high = file.sbumpc();
    const int low = file.sbumpc();
    for (int left = 256 * high + low - 2; left > 0 && byte != kEnd; --left) byte = file.sbumpc();
  }
  return false;
}

// The first three numbers behind "P5", with comments between.
void ReadPnm(FileBytes& file, Header& header) {
  constexpr size_t kMaxHeaderBytes = 4096;
  const std::string text = file.At(2, kMaxHeaderBytes);
  std::array<int64_t*, 3> numbers = {&header.width, &header.height, &header.largest};
  size_t at = 0;
  for (int64_t* number : numbers) {
    while (at < kMaxHeaderBytes && (text[at] < '0' || text[at] > '9')) {
      if (text[at] == '#') at = std::min(text.find('\n', at), kMaxHeaderBytes - 1);
      ++at;
    }
    for (; at < kMaxHeaderBytes && text[at] >= '0' && text[at] <= '9'; ++at) {
      *number = std::min<int64_t>(10 * *number + (text[at] - '0'), int64_t{1} << 40);
    }
  }
}

void ReadBmp(FileBytes& file, Header& header) {
  const bool is_old = file.Number(14, 4, true) == 12;
  const size_t count = is_old ? 2 : 4;
  header.width = file.Number(18, count, true);
  header.height = file.Number(18 + static_cast<int64_t>(count), count, true);
  if (!is_old && header.height >= int64_t{1} << 31) {  // negative: the first row is the upper one
    header.height = (int64_t{1} << 32) - header.height;
  }
}

// ImageWidth and ImageLength of the first directory (TIFF 6.0, section 2).
void ReadTiff(FileBytes& file, bool little_endian, Header& header) {
  const int64_t directory = file.Number(4, 4, little_endian);
  const int64_t entries = file.Number(directory, 2, little_endian);
  for (int64_t i = 0; i < entries; ++i) {
    const int64_t at = directory + 2 + 12 * i;
    const int64_t tag = file.Number(at, 2, little_endian);
    if (tag != 256 && tag != 257) continue;
    const bool is_short = file.Number(at + 2, 2, little_endian) == 3;
    const int64_t value = file.Number(at + 8, is_short ? 2 : 4, little_endian);
    (tag == 256 ? header.width : header.height) = value;
  }
  header.has_more_pages = file.Number(directory + 2 + 12 * entries, 4, little_endian) != 0;
}

std::optional<Header> ReadHeader(const std::filesystem::path& path) {
  using namespace std::string_view_literals;
  FileBytes file(path);
  const std::string begin = file.At(0, 8);
  const auto begins = [&](std::string_view magic) { return begin.starts_with(magic); };
  if (begins("\x89PNG\r\n\x1a\n"sv)) {
    return Header{ImageFormat::kPng, file.Number(16, 4, false), file.Number(20, 4, false)};
  }
  Header header{};
  if (begins("\xff\xd8\xff"sv)) {
    header.format = ImageFormat::kJpeg;
    ReadJpeg(file, header);
  } else if (begins("P2"sv) || begins("P3"sv) || begins("P5"sv) || begins("P6"sv)) {
    header.format = ImageFormat::kPnm;
    ReadPnm(file, header);
  } else if (begins("BM"sv)) {
    header.format = ImageFormat::kBmp;
    ReadBmp(file, header);
  } else if (begins("II*\0"sv) || begins("MM\0*"sv)) {
    header.format = ImageFormat::kTiff;
    ReadTiff(file, begins("II"sv), header);
  } else {
    return std::nullopt;
  }
  return header;
}

// What people give for an image, to stand behind what it is not; empty: none that is known.
std::string OtherFormat(const std::filesystem::path& path) {
  using namespace std::string_view_literals;
  constexpr std::pair<std::string_view, const char*> kOthers[] = {
      {"\x93NUMPY"sv, " (a NumPy array; cv2.imwrite makes a TIFF of it)"},
      {"PK\x03\x04"sv, " (an archive: .npz or .zip)"},
      {"version https://git-lfs"sv, " (a pointer of Git LFS; git lfs pull gets the file)"},
      {"PF\n"sv, " (a PFM in colour)"},
      {"Pf\n"sv, " (a PFM)"},
      {"RIFF"sv, " (WebP)"},
      {"\x76\x2f\x31\x01"sv, " (OpenEXR)"}};
  const std::string begin = FileBytes(path).At(0, 32);
  for (const auto& [magic, name] : kOthers) {
    if (begin.starts_with(magic)) return name;
  }
  return "";
}

std::string NamesOf(std::initializer_list<ImageFormat> formats) {
  std::string names;
  for (const ImageFormat& format : formats) {
    if (!names.empty()) names += &format + 1 == formats.end() ? " or " : ", ";
    names += kNames[static_cast<size_t>(format)];
  }
  return names;
}

// The pixels as in the file, and what its header says.
Result<CameraImage> Decode(const std::filesystem::path& path, int flags,
                           std::initializer_list<ImageFormat> formats) {
  const std::string name = "image " + path.string() + ": ";
  const std::string allowed = "; allowed: a readable " + NamesOf(formats) + " file";
  const auto undecodable = Fail(name + "cannot be decoded" + WhyClosed(path) + allowed);
  std::error_code ignored;
  if (std::filesystem::status(path, ignored).type() == std::filesystem::file_type::not_found) {
    return Fail(name + "is missing" + allowed);
  }
  if (!std::filesystem::is_regular_file(path, ignored)) return undecodable;  // a pipe would wait
  NoteInputFile(path);
  const std::optional<Header> header = ReadHeader(path);
  if (!header)
    return Fail(name + "cannot be decoded" + WhyClosed(path) + OtherFormat(path) + allowed);
  if (std::ranges::find(formats, header->format) == formats.end()) return undecodable;
  if (header->has_more_pages) {
    return Fail(name + "has several pages, of which one would be taken; allowed: one");
  }
  const auto [format, width, height, has_more_pages, largest] = *header;
  if (std::max(width, height) > kMaxSide || width * height > kMaxPixels) {
    return Fail(name + std::to_string(width) + "x" + std::to_string(height) +
                " px; allowed: 1 to " + std::to_string(kMaxSide) + " px a side and " +
                std::to_string(kMaxPixels) + " pixels");
  }
  if (format == ImageFormat::kJpeg && width > 0 && !HasJpegEnd(path)) {
    return Fail(name + "ends early, without an end-of-image marker; allowed: a whole JPEG file");
  }
  cv::Mat image;
  try {
    image = cv::imread(path.string(), flags | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {  // an empty image says it all
  }
  const cv::Size of_header(static_cast<int>(width), static_cast<int>(height));
  if (image.empty() || image.size() != of_header) {
    return undecodable;
  }
  return CameraImage{image, static_cast<int>(std::min<int64_t>(largest, 65535))};
}

}  // namespace

Result<cv::Mat> DecodeImageFile(const std::filesystem::path& path, int flags,
                                std::initializer_list<ImageFormat> formats) {
  const Result<CameraImage> image = Decode(path, flags, formats);
  if (!image) return tl::unexpected(image.error());
  return image->pixels;
}

Result<CameraImage> ReadCameraImage(const std::filesystem::path& path) {
  Result<CameraImage> image =
      Decode(path, cv::IMREAD_ANYCOLOR | cv::IMREAD_ANYDEPTH, kCameraFormats);
  if (image && image->pixels.depth() != CV_8U && image->pixels.depth() != CV_16U) {
    return Fail("image " + path.string() + ": of OpenCV's type " +
                cv::typeToString(image->pixels.type()) +
                "; allowed: grey or colour with 8 or 16 bits");
  }
  return image;
}

}  // namespace sprout
