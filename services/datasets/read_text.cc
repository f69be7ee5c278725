#include "services/datasets/read_text.h"

#include <cstdint>
#include <fstream>
#include <iterator>
#include <system_error>

#include "services/datasets/read_image.h"

namespace sprout::datasets {

std::optional<std::string> ReadText(const std::filesystem::path& path) {
  constexpr uintmax_t kMaxBytes = 1 << 20;
  if (!IsFile(path)) return {};
  std::error_code error;
  if (std::filesystem::file_size(path, error) > kMaxBytes || error) return {};
  std::ifstream file(path);
  if (!file) return {};
  return std::string{std::istreambuf_iterator<char>(file), {}};
}

}  // namespace sprout::datasets
