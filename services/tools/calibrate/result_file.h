#pragma once

#include <filesystem>
#include <iostream>
#include <stdexcept>
#include <vector>

#include "common/app/output_paths.h"
#include "common/core/input_files.h"
#include "common/rig/rig_file.h"

namespace sprout::calibrate {

/// Checks that results can be written: the rig file `out`, also in place of `rig`, which is read,
/// but of no other input; and `report`, if there is one, in place of none.
/// @throws ConfigError that names the flag.
inline void RequireResultFiles(const std::vector<std::filesystem::path>& inputs,
                               const std::filesystem::path& rig, const std::filesystem::path& out,
                               const std::filesystem::path& report) {
  for (const std::filesystem::path& input : inputs) NoteInputFile(input);
  RequireWritableFile("--out", out);
  NoteInputFile(rig);
  if (!report.empty()) RequireWritableFile("--report", report);
}

/// Writes a rig file; a calibration that is not good does not take the place of one that may be: it
/// goes to NAME.not_good.textproto beside, which is said.
/// @throws std::runtime_error when it cannot be written.
inline void SaveResult(const RigDescription& rig, bool is_good, const std::filesystem::path& out) {
  std::filesystem::path file = out;
  if (!is_good) file.replace_filename(out.stem().string() + ".not_good" + out.extension().string());
  if (const Result<void> saved = SaveRigFile(file, rig); !saved) {
    throw std::runtime_error(saved.error().text);
  }
  if (!is_good) {
    std::cout << "not written to " << out.string() << ", but to " << file.string() << "\n";
  }
}

}  // namespace sprout::calibrate
