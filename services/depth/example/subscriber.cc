// Prints how far away the middle of every depth image is. Hears SPROUT_DEPTH where LCM_DEFAULT_URL
// says, as any LCM program does:
//   LCM_DEFAULT_URL='udpm://239.255.76.67:7667?ttl=0&recv_buf_size=67108864' ./subscriber
#include <iostream>
#include <lcm/lcm-cpp.hpp>
#include <lcmtypes/sprout/depth_image_t.hpp>
#include <string>

struct Printer {
  void OnDepth(const lcm::ReceiveBuffer*, const std::string&, const sprout::depth_image_t* image) {
    const int pixel = image->height / 2 * image->width + image->width / 2;
    const int count = image->depth[2 * pixel] + 256 * image->depth[2 * pixel + 1];
    std::cout << "frame " << image->header.seq << ": ";
    if (count == 0) {
      std::cout << "no depth" << std::endl;
    } else {
      std::cout << count * image->metres_per_count << " m" << std::endl;
    }
  }
};

int main() {
  lcm::LCM lcm;
  if (!lcm.good()) {
    std::cerr << "subscriber: no LCM network where LCM_DEFAULT_URL says\n";
    return 1;
  }
  Printer printer;
  lcm.subscribe("SPROUT_DEPTH", &Printer::OnDepth, &printer);
  while (lcm.handle() == 0) {
  }
  return 1;
}
