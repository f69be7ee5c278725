#include "services/tools/evaluate/rivals/rival.h"

namespace sprout::evaluate {

std::vector<Rival> AllRivals() { return {Sgbm3Way(), Sgbm5Way(), Bm(), BmWls(), Fgs()}; }

}  // namespace sprout::evaluate
