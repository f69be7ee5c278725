#include <pybind11/stl.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <utility>

#include "common/app/silence_watch.h"
#include "common/app/stage_monitor.h"
#include "common/bus/channels.h"
#include "common/bus/lcm_url.h"
#include "common/bus/mailbox.h"
#include "common/bus/receiver.h"
#include "common/frames/frame_joiner.h"
#include "services/python/bindings.h"

namespace sprout::python {
namespace {

using Clock = std::chrono::steady_clock;

std::string UrlOrDefault(const std::optional<std::string>& url) {
  if (url) {
    if (const auto error = LcmUrlError(*url)) throw py::value_error("url: " + *error);
    return *url;
  }
  const char* from_environment = std::getenv("LCM_DEFAULT_URL");
  return from_environment && *from_environment ? from_environment : kDefaultLcmUrl;
}

std::vector<std::string_view> ChannelsOf(const PartSet& parts) {
  std::vector<std::string_view> channels;
  for (const Part part : kAllParts) {
    if (parts.Has(part)) channels.push_back(ChannelOf(part));
  }
  return channels;
}

// Short enough that a warning comes before the timeout and can be its reason.
std::chrono::milliseconds PatienceOf(const std::optional<double>& timeout_s) {
  constexpr std::chrono::milliseconds kShortest{100};
  if (!timeout_s ||
      *timeout_s >= 3 * std::chrono::duration<double>(SilenceWatch::kPatience).count()) {
    return SilenceWatch::kPatience;
  }
  return std::max(kShortest, std::chrono::milliseconds(std::llround(*timeout_s * 1000 / 3)));
}

// The newest whole frame of the running graph; older ones that nobody took are counted.
class Listener {
 public:
  Listener(const PartSet& parts, const std::string& prefix, const std::string& url,
           std::optional<double> timeout_s)
      : timeout_s_(timeout_s),
        joiner_(parts),
        silence_({.stage = "listen",
                  .config = {},
                  .lcm_url = url,
                  .prefix = prefix,
                  .replay = {},
                  .stop = {}},
                 ChannelsOf(parts), monitor_, PatienceOf(timeout_s)),
        receiver_(
            url, prefix, ChannelsOf(parts),
            [this](std::string_view channel, std::span<const uint8_t> bytes) {
              Take(channel, bytes);
            },
            [this](std::string_view) { ++bad_messages_; }) {}

  PyFrame Next() {
    const Turn turn(taken_, "listen()");
    const Unlocked free;
    SignalCheck check;
    const auto begun = Clock::now();
    while (true) {
      if (auto frame = mailbox_.TakeWithin(SignalCheck::kPeriod, {})) {
        return {.frame = std::move(*frame)};
      }
      check();
      WarnOfSilence();
      const double waited_s = std::chrono::duration<double>(Clock::now() - begun).count();
      if (timeout_s_ && waited_s > *timeout_s_) {
        const Locked gil;
        const std::string text = "no frame within timeout_s" +
                                 (warned_.empty() ? "; does the graph run?" : ": " + warned_);
        PyErr_SetString(PyExc_TimeoutError, text.c_str());
        throw py::error_already_set();
      }
    }
  }

  int64_t skipped() const { return skipped_; }
  int64_t bad_messages() const { return bad_messages_; }
  int64_t incomplete() const { return incomplete_; }

 private:
  void Take(std::string_view channel, std::span<const uint8_t> bytes) {
    silence_.Heard(channel);
    Result<std::vector<Frame>> frames = joiner_.AddMessage(*PartOf(channel), bytes);
    if (!frames) ++bad_messages_;
    incomplete_ = joiner_.incomplete();
    if (!frames) return;
    if (!frames->empty()) silence_.HeardFrame();
    for (Frame& frame : *frames) skipped_ += mailbox_.Put(std::move(frame));
  }

  // A caller that waits without a timeout would never learn why.
  void WarnOfSilence() {
    const std::string text = monitor_.Snapshot().last_error;
    if (text == std::exchange(warned_, text) || text.empty()) return;
    const Locked gil;
    if (PyErr_WarnEx(PyExc_RuntimeWarning, text.c_str(), 1) != 0) throw py::error_already_set();
  }

  std::optional<double> timeout_s_;
  std::string warned_;  // the newest warning, while it holds
  FrameJoiner joiner_;
  StageMonitor monitor_{"listen", ""};
  SilenceWatch silence_;
  Mailbox<Frame> mailbox_;
  std::atomic<int64_t> skipped_ = 0;
  std::atomic<int64_t> bad_messages_ = 0;
  std::atomic<int64_t> incomplete_ = 0;
  std::atomic_flag taken_;
  Receiver receiver_;  // last: stops before the rest is destroyed
};

std::unique_ptr<Listener> Listen(const py::object& parts, const std::string& prefix,
                                 const std::optional<std::string>& url,
                                 std::optional<double> timeout_s) {
  if (!IsChannelPrefix(prefix)) {
    throw py::value_error("prefix '" + prefix + "': allowed are " + AllowedChannelPrefix());
  }
  if (timeout_s && !(*timeout_s >= 0)) {
    throw py::value_error("timeout_s: expected 0 and more, or None: for ever; given " +
                          std::string(py::repr(py::float_(*timeout_s))));
  }
  const PartSet set =
      parts.is_none() ? PartSet{Part::kLeft, Part::kDisparity, Part::kRig} : TakeParts(parts);
  if (set == PartSet{} || set == PartSet{Part::kRig}) {
    throw py::value_error("parts: expected at least one beside rig, given " +
                          std::string(py::repr(parts)));
  }
  const std::string address = UrlOrDefault(url);
  const Unlocked free;
  return std::make_unique<Listener>(set, prefix, address, timeout_s);
}

}  // namespace

void BindListen(py::module_& module) {
  py::class_<Listener>(module, "Listener", "Frames of the running graph, see listen().")
      .def(
          "__iter__", [](py::object self) { return self; }, "__iter__(self) -> Listener")
      .def("__next__", &Listener::Next, "__next__(self) -> Frame")
      .def_property_readonly(
          "skipped", &Listener::skipped,
          "int: frames that were replaced by a newer one before they were taken.")
      .def_property_readonly("incomplete", &Listener::incomplete,
                             "int: frames of which a part never came.")
      .def_property_readonly(
          "bad_messages", &Listener::bad_messages,
          "int: messages that could not be used, or came faster than they could be.")
      .def(
          "__repr__", [](const Listener&) { return "<sprout.Listener>"; }, "__repr__(self) -> str");
  module.def(
      "listen", &Listen, py::arg("parts") = py::none(), py::arg("prefix") = "",
      py::arg("url") = py::none(), py::arg("timeout_s") = py::none(),
      R"(listen(parts: Optional[Sequence[str]] = ..., prefix: str = ..., url: Optional[str] = ..., timeout_s: Optional[float] = ...) -> Listener

Frames of the running graph, each whole: for frame in sprout.listen(["left", "disparity", "rig"]): ...
The newest one; what was replaced before it was taken is counted.
parts: that a frame must have; None: left, disparity and rig.
prefix: of the channels, as --channel-prefix. url: as --lcm-url; None: LCM_DEFAULT_URL, or the graph's own.
timeout_s: TimeoutError when no frame comes for so long; None: waits for ever, and a RuntimeWarning says what is
missing after 6 s. Ctrl-C ends it.)");
}

}  // namespace sprout::python
