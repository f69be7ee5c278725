#include "services/tools/calibrate/program.h"

int main(int argc, char** argv) { return sprout::calibrate::CalibrateMain(argc, argv); }
