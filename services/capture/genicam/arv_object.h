#pragma once

#include <arv.h>

#include <memory>
#include <string>

namespace sprout::capture {

/// Owns one reference of a GObject.
template <typename T>
struct ArvUnref {
  void operator()(T* object) const { g_object_unref(object); }
};
template <typename T>
using ArvObject = std::unique_ptr<T, ArvUnref<T>>;

/// Owns memory of GLib.
template <typename T>
struct GFree {
  void operator()(T* memory) const { g_free(memory); }
};
template <typename T>
using GMemory = std::unique_ptr<T, GFree<T>>;

/// Catches what an Aravis call reports: pass out() as its last argument.
class ArvError {
 public:
  ArvError() = default;
  ArvError(const ArvError&) = delete;
  ArvError& operator=(const ArvError&) = delete;
  ~ArvError() { g_clear_error(&error_); }

  /// Place for the error of another call; clears the previous error.
  GError** out() {
    g_clear_error(&error_);
    return &error_;
  }

  explicit operator bool() const { return error_ != nullptr; }
  std::string text() const { return error_ ? error_->message : ""; }

 private:
  GError* error_ = nullptr;
};

/// Text of Aravis, which may be null.
inline std::string ArvText(const char* text) { return text ? text : ""; }

}  // namespace sprout::capture
