#include "services/tools/quality/program.h"

int main(int argc, char** argv) { return sprout::quality::QualityMain(argc, argv); }
