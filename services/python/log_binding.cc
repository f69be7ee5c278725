#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <system_error>

#include "common/frames/log_frames.h"
#include "services/python/bindings.h"

namespace sprout::python {
namespace {

namespace fs = std::filesystem;

// Messages that could not be used.
struct Refused {
  int64_t count = 0;
  std::string first;

  sprout::Refuse Counter() {
    return [this](const LogEvent& event, const std::string& why) {
      if (count++ == 0) first = std::string(event.channel) + ": " + why;
    };
  }
};

// What one pass over the whole log has found.
struct Contents {
  explicit Contents(const std::string& prefix) : index({.prefix = prefix}) {}

  FrameIndex index;
  std::map<std::string, int64_t, std::less<>> channels;
  std::vector<LogDamage> damage;
};

Frame FetchFrame(EventFetcher& fetcher, const IndexedFrame& places, const PartSet& parts,
                 Refused& refused) {
  Frame frame;
  frame.id = places.id;
  for (auto& [part, value] : FetchParts(fetcher, places, parts, refused.Counter())) {
    SetPart(frame, part, std::move(value));
  }
  return frame;
}

class PyLog {
 public:
  PyLog(fs::path path, std::string prefix) : path_(std::move(path)), prefix_(std::move(prefix)) {
    std::error_code unreadable;  // reported when the file is opened
    if (!fs::exists(path_, unreadable) && !unreadable) {
      SetError(PyExc_FileNotFoundError, path_.string() + ": no such file");
      throw py::error_already_set();
    }
    fetcher_ = std::make_unique<EventFetcher>(path_);
    LogReader reader(path_);  // says when it is no log
  }

  const Contents& Look() {
    RequireOpen();
    if (contents_) return *contents_;
    const Turn turn(taken_, "Log");
    auto contents = std::make_unique<Contents>(prefix_);
    {
      const Unlocked free;
      Read(*contents);
    }
    contents_ = std::move(contents);
    return *contents_;
  }

  int64_t Count() { return std::ssize(Look().index.frames()); }

  PyFrame At(int64_t number) {
    const int64_t count = Count();
    const int64_t at = number < 0 ? number + count : number;
    if (at < 0 || at >= count) {
      throw py::index_error("frame " + std::to_string(number) + ": the log has " +
                            std::to_string(count));
    }
    const Turn turn(taken_, "Log");
    const Unlocked free;
    return {.frame = FetchFrame(*fetcher_, contents_->index.At(static_cast<size_t>(at)), AllParts(),
                                refused_)};
  }

  int64_t Seek(std::optional<int64_t> seq, std::optional<int64_t> utime) {
    if (seq.has_value() == utime.has_value()) {
      throw py::value_error("seek: expected seq or utime, given both or neither");
    }
    const auto& frames = Look().index.frames();
    const auto found = std::ranges::find_if(frames, [&](const IndexedFrame& frame) {
      return seq ? frame.id.seq == *seq : frame.id.utime >= *utime;
    });
    if (found != frames.end()) return found - frames.begin();
    throw py::key_error(seq ? "seq " + std::to_string(*seq) + ": no such frame"
                            : "utime " + std::to_string(*utime) + ": no frame so late");
  }

  void Close() {
    const Turn turn(taken_, "Log");
    fetcher_.reset();
  }

  void RequireOpen() const {
    if (!fetcher_) throw py::value_error("the log is closed");
  }

  const fs::path& path() const { return path_; }
  const std::string& prefix() const { return prefix_; }
  bool is_open() const { return fetcher_ != nullptr; }
  const Refused& refused() const { return refused_; }
  Refused& refused() { return refused_; }

 private:
  void Read(Contents& contents) {
    SignalCheck check;
    LogReader reader(path_);
    const sprout::Refuse refuse = refused_.Counter();
    for (LogEvent event; reader.Next(event); check()) {
      contents.index.Add(event, refuse);
      const auto known = contents.channels.find(event.channel);
      if (known != contents.channels.end()) {
        ++known->second;
      } else {
        contents.channels.emplace(event.channel, 1);
      }
    }
    contents.damage = reader.damage();
  }

  fs::path path_;
  std::string prefix_;
  std::unique_ptr<EventFetcher> fetcher_;
  std::unique_ptr<Contents> contents_;
  Refused refused_;
  std::atomic_flag taken_;
};

// An iterator with a reader of its own, so that several can read one log. From the start on it
// needs no index.
class PyLogFrames {
 public:
  PyLogFrames(PyLog& log, const PartSet& parts, int64_t start)
      : log_(log), parts_(parts), next_(start) {
    log.RequireOpen();
    if (start < 0)
      throw py::value_error("start: expected 0 or more, given " + std::to_string(start));
    if (start > 0) {
      log.Look();
      fetcher_ = std::make_unique<EventFetcher>(log.path());
    } else {
      frames_ = std::make_unique<LogFrames>(
          log.path(), FrameChoice{.prefix = log.prefix(), .parts = parts}, refused_.Counter());
    }
  }

  PyFrame Next() {
    log_.RequireOpen();
    const Turn turn(taken_, "frames()");
    std::optional<Frame> frame = fetcher_ ? NextIndexed() : NextRead();
    if (!frame) throw py::stop_iteration();
    return {.frame = std::move(*frame)};
  }

  const Refused& refused() const { return refused_; }

 private:
  std::optional<Frame> NextRead() {
    const Unlocked free;
    SignalCheck check;
    return frames_->Next([&](int64_t) { check(); });
  }

  std::optional<Frame> NextIndexed() {
    const FrameIndex& index = log_.Look().index;
    if (next_ >= std::ssize(index.frames())) return std::nullopt;
    const Unlocked free;
    return FetchFrame(*fetcher_, index.At(static_cast<size_t>(next_++)), parts_, refused_);
  }

  PyLog& log_;
  PartSet parts_;
  int64_t next_;
  Refused refused_;
  std::unique_ptr<LogFrames> frames_;
  std::unique_ptr<EventFetcher> fetcher_;
  std::atomic_flag taken_;
};

py::list DamageOf(PyLog& log) {
  py::list list;
  for (const LogDamage& damage : log.Look().damage) list.append(SkippedText(damage));
  return list;
}

void BindLogFrames(py::module_& module) {
  py::class_<PyLogFrames> bound(module, "LogFrames", "The frames of a log one after the other.");
  bound
      .def(
          "__iter__", [](py::object self) { return self; }, "__iter__(self) -> LogFrames")
      .def("__next__", &PyLogFrames::Next, "__next__(self) -> Frame")
      .def_property_readonly(
          "bad_messages", [](const PyLogFrames& frames) { return frames.refused().count; },
          "int: messages so far that could not be used, and were left out.")
      .def_property_readonly(
          "first_bad_message", [](const PyLogFrames& frames) { return frames.refused().first; },
          "str: channel of the first of them, and what is wrong with it.");
  AddRepr(bound, [](const PyLogFrames&) { return "<sprout.LogFrames>"; });
}

}  // namespace

void BindLog(py::module_& module) {
  BindLogFrames(module);
  py::class_<PyLog> bound(module, "Log",
                          R"(The frames of a log that lcm-logger, sprout-record or a replay wrote.

    with sprout.Log("run.lcm") as log:
        for frame in log.frames():
            ...

Damage is skipped (damage says where), compressed maps and pictures are decoded. frames() takes the
memory of one frame, whatever the length of the log; len(), [], seek() and channels look through the
whole log once, and then know where its frames stand (300 bytes each). For one thread at a time; reads
without the interpreter's lock.)");
  const auto add = PropertiesOf(bound);
  bound
      .def(py::init<fs::path, std::string>(), py::arg("path"), py::arg("prefix") = "",
           R"(__init__(self, path: Union[str, os.PathLike[str]], prefix: str = ...) -> None

prefix: of the graph's channels, as --channel-prefix. OSError when it cannot be read or is no log.)")
      .def(
          "frames",
          [](PyLog& log, const py::object& parts, int64_t start) {
            return std::make_unique<PyLogFrames>(log, TakeParts(parts), start);
          },
          py::arg("parts") = py::none(), py::arg("start") = 0, py::keep_alive<0, 1>(),
          R"(frames(self, parts: Optional[Sequence[str]] = ..., start: int = ...) -> LogFrames

Frames in order, each with what the log holds of it, whole or not.
parts: names of those that are read ("left", "disparity", "rig"), which is faster; None: all.
start: number of the first one, from 0, as seek() gives it.)")
      .def(
          "__iter__", [](PyLog& log) { return std::make_unique<PyLogFrames>(log, AllParts(), 0); },
          py::keep_alive<0, 1>(), "__iter__(self) -> LogFrames")
      .def("__len__", &PyLog::Count, "__len__(self) -> int")
      .def("__getitem__", &PyLog::At, py::arg("number"),
           "__getitem__(self, number: int) -> Frame\n\nFrame by its place in the log, from 0; "
           "negative from the end.")
      .def("seek", &PyLog::Seek, py::arg("seq") = py::none(), py::arg("utime") = py::none(),
           R"(seek(self, seq: Optional[int] = ..., utime: Optional[int] = ...) -> int

Place in the log of the first frame with this seq, or of the first one not before utime (us); for
log[place] and frames(start=place). KeyError when there is none.)");
  add("channels", "Dict[str, int]: events of each channel.", [](PyLog& log) {
    py::dict channels;
    for (const auto& [name, count] : log.Look().channels) channels[TextOfBytes(name)] = count;
    return channels;
  });
  add("damage", "List[str]: unreadable stretches, where and how long.", &DamageOf);
  add("bad_messages", "int: messages that len(), [] and the like could not use.",
      [](PyLog& log) { return log.refused().count; });
  add("path", "str: of the file.",
      [](const PyLog& log) { return TextOfBytes(log.path().string()); });
  bound.def("close", &PyLog::Close, "close(self) -> None")
      .def(
          "__enter__", [](py::object self) { return self; }, "__enter__(self) -> Log")
      .def(
          "__exit__", [](PyLog& log, const py::args&) { log.Close(); },
          "__exit__(self, *args: Any) -> None");
  AddRepr(bound, [](const PyLog& log) {
    return "<sprout.Log " + std::string(py::repr(TextOfBytes(log.path().string()))) +
           (log.is_open() ? ">" : " closed>");
  });
}

}  // namespace sprout::python
