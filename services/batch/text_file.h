#ifndef SPROUT_SERVICES_BATCH_TEXT_FILE_H_
#define SPROUT_SERVICES_BATCH_TEXT_FILE_H_

#include <filesystem>
#include <string>

#include "common/core/output_file.h"
#include "common/core/read_text.h"
#include "common/logfile/log_error.h"

namespace sprout::batch {

/// Renames a file. @throws LogError, one line with the reason.
inline void CommitFile(const std::filesystem::path& path, OutputFile& file) {
  if (!file.Commit()) throw LogError(path, "cannot be written (" + file.failure() + ")");
}

/// Writes a file, see OutputFile. @throws LogError.
inline void WriteText(const std::filesystem::path& path, const std::string& text) {
  OutputFile file(path);
  file.Write(text);
  CommitFile(path, file);
}

/// Empty where there is no such file.
inline std::string FirstLineOf(const std::filesystem::path& path) {
  const std::string text = ReadText(path, kMaxListBytes).value_or("");
  return text.substr(0, text.find('\n'));
}

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_BATCH_TEXT_FILE_H_
