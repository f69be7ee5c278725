#ifndef SPROUT_SERVICES_TOOLS_EVALUATE_METHODS_H_
#define SPROUT_SERVICES_TOOLS_EVALUATE_METHODS_H_

#include <functional>
#include <string>
#include <vector>

#include "services/tools/evaluate/chain.h"
#include "services/tools/evaluate/scene.h"

namespace sprout::evaluate {

/// One row of the tables: a way to a disparity map.
struct Method {
  std::string name;
  std::string summary;  ///< one line for --help
  std::function<MethodOutput(const Scene&, const ChainSettings&)> run;
};

/// Every method, in the order of the tables: sprout, those of the paper's table, rivals.
std::vector<Method> AllMethods();

/// The methods of that name or in that group ("paper": those of the paper's table, "all"), in the
/// order asked for, each once.
/// @throws ConfigError for an unknown name, listing those that exist.
std::vector<Method> SelectMethods(const std::vector<std::string>& names);

}  // namespace sprout::evaluate

#endif  // SPROUT_SERVICES_TOOLS_EVALUATE_METHODS_H_
