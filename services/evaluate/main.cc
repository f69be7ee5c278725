#include "services/evaluate/program.h"

int main(int argc, char** argv) { return sprout::EvaluateMain(argc, argv); }
