#ifndef SPROUT_TESTS_COMMON_CORE_GERMAN_LOCALE_H_
#define SPROUT_TESTS_COMMON_CORE_GERMAN_LOCALE_H_

#include <cstdlib>
#include <locale>
#include <stdexcept>
#include <string>

#include "tests/common/picture/temporary_directory.h"

namespace sprout {

/// A program that has set the user's locale, where commas are decimal and dots are not; while it
/// lives. The locale is made where it stands, from what Debian's package locales brings.
class GermanLocale {
 public:
  GermanLocale() {
    const std::string folder = (folder_ / "de_DE.UTF-8").string();
    const std::string make = "localedef -i de_DE -f UTF-8 '" + folder + "' 2>&1";
    if (std::system(make.c_str()) != 0) return;
    setenv("LOCPATH", (folder_ / "").c_str(), 1);
    try {
      std::locale::global(std::locale("de_DE.UTF-8"));  // C's, too
      is_set_ = true;
    } catch (const std::runtime_error&) {
    }
  }
  ~GermanLocale() {
    std::locale::global(std::locale::classic());
    unsetenv("LOCPATH");
  }
  GermanLocale(const GermanLocale&) = delete;
  GermanLocale& operator=(const GermanLocale&) = delete;

  bool is_set() const { return is_set_; }

 private:
  TemporaryDirectory folder_;
  bool is_set_ = false;
};

}  // namespace sprout

#endif  // SPROUT_TESTS_COMMON_CORE_GERMAN_LOCALE_H_
