#include "services/tools/batch/program.h"

int main(int argc, char** argv) { return sprout::batch::BatchMain(argc, argv); }
