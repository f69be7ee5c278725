#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "common/bus/channels.h"
#include "common/logfile/log_writer.h"
#include "common/messages/codec.h"
#include "common/scenes/dataset.h"
#include "tests/system/run_program.h"

namespace sprout {

/// Three stages over all logs of a folder.
inline std::vector<std::string> RunCommand(const std::filesystem::path& logs,
                                           const std::filesystem::path& out) {
  return {"sprout-batch", "run", logs, "--out", out, "--config", "fast"};
}

/// The cells of a column of frames.csv; NaN where they are empty.
inline std::vector<double> ColumnOf(const std::filesystem::path& out, const std::string& name) {
  std::ifstream file(out / "frames.csv");
  std::vector<double> column;
  std::ptrdiff_t at = -1;
  for (std::string line; std::getline(file, line);) {
    std::vector<std::string> cells;
    std::istringstream rest(line);
    for (std::string cell; std::getline(rest, cell, ',');) cells.push_back(cell);
    if (at < 0) {
      at = std::ranges::find(cells, name) - cells.begin();
      EXPECT_LT(at, std::ssize(cells)) << "no column " << name;
    } else {
      const std::string cell = at < std::ssize(cells) ? cells[static_cast<size_t>(at)] : "";
      column.push_back(cell.empty() ? std::nan("") : std::stod(cell));
    }
  }
  return column;
}

/// A log of a moving scene as a slow recorder sees it: RIGHT and TOF of a frame come when LEFT of
/// the next two frames is there already, TOF of frames 5 and 13 never comes, and the
/// calibration comes behind the first frames. As with lcm-logger, an event may be older than the
/// one before it: every third is, and whatever follows one that no stage takes.
inline void WriteStraddlingLog(const std::filesystem::path& path, const std::string& size,
                               int64_t first, int64_t frames) {
  SproutConfig config = LoadConfig({"default"});
  config.mutable_capture()->set_source("synthetic:" + size);
  const auto scene = scenes::OpenDataset(config.capture());
  const std::string rig_id = RigId(scene->rig());
  LogWriter writer(path);
  const auto time = [&] {
    return 1'700'000'000'000'000 + 100'000 * writer.events() -
           (writer.events() % 3 == 0 ? 150'000 : 0);
  };
  const auto write = [&](Part part, int64_t i, const PartValue& value) {
    const FrameId id{.utime = 1'700'000'000'000'000 + 100'000 * i, .seq = i, .rig_id = rig_id};
    writer.Write(time(), ChannelOf(part), EncodePart(id, part, value));
  };
  std::vector<scenes::DatasetFrame> late;
  for (int64_t i = 0; i < frames + 2; ++i) {
    if (i < frames) {
      late.push_back(scene->Get(first + i));
      write(Part::kLeft, i, late.back().left);
      writer.Write(time() + 350'000, "OTHER", {});
    }
    if (i == 3) write(Part::kRig, i, scene->rig());
    if (i < 2) continue;
    const scenes::DatasetFrame& frame = late[static_cast<size_t>(i - 2)];
    write(Part::kRight, i - 2, frame.right);
    if (i != 7 && i != 15) write(Part::kTof, i - 2, frame.tof);
  }
  writer.Close();
}

}  // namespace sprout
