#include "services/tools/log/program.h"

int main(int argc, char** argv) { return sprout::log::LogMain(argc, argv); }
