#include "common/picture/output_file.h"

#include <bit>
#include <cerrno>
#include <system_error>
#include <utility>

namespace sprout {
namespace {

static_assert(std::endian::native == std::endian::little, "WriteNumber() writes memory as it is");

constexpr size_t kBufferBytes = size_t{1} << 20;

}  // namespace

OutputFile::OutputFile(std::filesystem::path path) : path_(std::move(path)), part_path_(path_) {
  part_path_ += ".part";
  file_ = std::fopen(part_path_.c_str(), "wb");
  if (file_ == nullptr) {
    error_number_ = errno;
    return;
  }
  std::setvbuf(file_, nullptr, _IONBF, 0);  // buffer_ does that
  buffer_.reserve(kBufferBytes);
}

OutputFile::~OutputFile() {
  if (file_ == nullptr) return;
  std::fclose(file_);
  std::remove(part_path_.c_str());
}

void OutputFile::Write(std::string_view bytes) {
  if (error_number_ != 0) return;
  if (buffer_.size() + bytes.size() > kBufferBytes) Flush();
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

void OutputFile::Flush() {
  if (error_number_ == 0 &&
      std::fwrite(buffer_.data(), 1, buffer_.size(), file_) != buffer_.size()) {
    error_number_ = errno;
  }
  buffer_.clear();
}

Result<void> OutputFile::Commit() {
  if (file_ != nullptr) {
    Flush();
    if (std::fclose(std::exchange(file_, nullptr)) != 0 && error_number_ == 0) {
      error_number_ = errno;
    }
    if (error_number_ == 0 && std::rename(part_path_.c_str(), path_.c_str()) != 0) {
      error_number_ = errno;
    }
    if (error_number_ != 0) std::remove(part_path_.c_str());
  }
  if (error_number_ == 0) return {};
  return Fail("cannot write " + path_.string() + ": " +
              std::generic_category().message(error_number_));
}

}  // namespace sprout
