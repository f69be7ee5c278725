#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

namespace sprout {

/// A log that cannot be opened, read or written. what() is one line that names file and reason.
class LogError : public std::runtime_error {
 public:
  LogError(const std::filesystem::path& path, const std::string& reason)
      : std::runtime_error(path.string() + ": " + reason), path_(path) {}

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace sprout
