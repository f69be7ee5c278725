#pragma once

#include <string>

#include "common/core/digest.h"
#include "services/tools/batch/manifest.h"

namespace sprout::batch {

/// prior and grow on two logs, x and y, with two variants.
inline Manifest ExampleManifest() {
  Manifest manifest;
  manifest.set_format(kManifestFormat);
  for (const char* stage : {"prior", "grow"}) manifest.add_stage(stage);
  manifest.set_channel_prefix("");
  manifest.set_tables(Digest("tables"));
  for (const char* name : {"a", "b"}) {
    Variant& variant = *manifest.add_variant();
    variant.set_config_digest(Digest(name));
    for (const std::string& stage : manifest.stage()) {
      StageProgram& program = *variant.add_program();
      program.set_path("/bin/sprout-" + stage);
      program.set_digest(Digest(stage));
      program.set_version("1.0");
    }
  }
  for (const std::string name : {"x", "y"}) {
    BatchLog& log = *manifest.add_log();
    log.set_path("/logs/" + name + ".lcm");
    log.set_name(name);
    log.set_digest(Digest(name));
  }
  return manifest;
}

}  // namespace sprout::batch
