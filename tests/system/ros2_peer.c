/* A camera driver and a listener as ROS 2 nodes are on the wire, with an IDL of its own.
 *   ros2_peer send RIG WIDTH HEIGHT HZ SECONDS   RIG/left/image_rect, RIG/right/image_rect, camera_info of both,
 *     RIG/points: a wall 2 m away, one point behind every 100th pixel of every 100th row
 *   ros2_peer send_text TOPIC SECONDS            a string on a topic, 10 Hz
 *   ros2_peer hear SECONDS SLEEP_S RELIABLE TOPIC=TYPE...
 *     counts messages (TYPE: image, points), how many bytes they had, and those that DDS knows to be lost; sleeps
 *     first, with its readers open; SIGTERM ends it */
#include <dds/dds.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "ros2_peer.h"

enum { MOST = 8 };

static volatile sig_atomic_t has_to_end = 0;
static void on_signal(int signal) {
  (void)signal;
  has_to_end = 1;
}

static int64_t now_us(void) {
  struct timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  return (int64_t)now.tv_sec * 1000000 + now.tv_nsec / 1000;
}

static void sleep_us(int64_t us) {
  if (us <= 0) return;
  struct timespec time = {us / 1000000, us % 1000000 * 1000};
  nanosleep(&time, NULL);
}

static dds_qos_t* qos_of(bool reliable) {
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                       DDS_MSECS(100));
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 5);
  return qos;
}

static dds_entity_t topic_of(dds_entity_t participant, const dds_topic_descriptor_t* type,
                             const char* name) {
  char full[256];
  snprintf(full, sizeof full, "rt%s", name);
  return dds_create_topic(participant, type, full, NULL, NULL);
}

static dds_entity_t writer_of(dds_entity_t participant, const dds_topic_descriptor_t* type,
                              const char* rig, const char* name) {
  char topic[256];
  snprintf(topic, sizeof topic, "%s%s", rig, name);
  return dds_create_writer(participant, topic_of(participant, type, topic), qos_of(true), NULL);
}

static sensor_msgs_msg_dds__CameraInfo_ info_of(uint32_t width, uint32_t height, double tx) {
  sensor_msgs_msg_dds__CameraInfo_ info = {0};
  const double f = 1000, cx = width / 2.0, cy = height / 2.0;
  info.header.frame_id = "camera";
  info.width = width;
  info.height = height;
  info.distortion_model = "plumb_bob";
  const double k[9] = {f, 0, cx, 0, f, cy, 0, 0, 1};
  const double r[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  const double p[12] = {f, 0, cx, tx, 0, f, cy, 0, 0, 0, 1, 0};
  memcpy(info.k, k, sizeof k);
  memcpy(info.r, r, sizeof r);
  memcpy(info.p, p, sizeof p);
  return info;
}

/* As drivers of lidars have it: x, y, z and intensity. */
static sensor_msgs_msg_dds__PointCloud2_ wall_of(uint32_t width, uint32_t height) {
  static char* const names[4] = {"x", "y", "z", "intensity"};
  static sensor_msgs_msg_dds__PointField_ fields[4];
  sensor_msgs_msg_dds__PointCloud2_ wall = {0};
  const uint32_t every = 100, count = (width / every) * (height / every);
  float* at = malloc(count * 4 * sizeof(float));
  wall.header.frame_id = "camera";
  wall.height = 1;
  wall.width = count;
  wall.point_step = 4 * sizeof(float);
  wall.row_step = count * wall.point_step;
  wall.is_dense = true;
  wall.data._length = wall.data._maximum = wall.row_step;
  wall.data._buffer = (uint8_t*)at;
  for (uint32_t i = 0; i < 4; ++i) {
    fields[i].name = names[i];
    fields[i].offset = i * (uint32_t)sizeof(float);
    fields[i].datatype = 7; /* FLOAT32 */
    fields[i].count = 1;
  }
  wall.fields._length = wall.fields._maximum = 4;
  wall.fields._buffer = fields;
  const float f = 1000, z = 2;
  for (uint32_t v = 0; v < height / every; ++v) {
    for (uint32_t u = 0; u < width / every; ++u, at += 4) {
      at[0] = ((float)(u * every) - (float)width / 2) * z / f;
      at[1] = ((float)(v * every) - (float)height / 2) * z / f;
      at[2] = z;
      at[3] = 0.5f;
    }
  }
  return wall;
}

static int send_rig(dds_entity_t participant, char** argv) {
  const char* rig = argv[0];
  const uint32_t width = (uint32_t)atoi(argv[1]), height = (uint32_t)atoi(argv[2]);
  const double hz = atof(argv[3]);
  const int frames = (int)(hz * atof(argv[4]));
  const dds_topic_descriptor_t* image_type = &sensor_msgs_msg_dds__Image__desc;
  const dds_topic_descriptor_t* info_type = &sensor_msgs_msg_dds__CameraInfo__desc;
  const dds_entity_t images[2] = {writer_of(participant, image_type, rig, "/left/image_rect"),
                                  writer_of(participant, image_type, rig, "/right/image_rect")};
  const dds_entity_t infos[2] = {writer_of(participant, info_type, rig, "/left/camera_info"),
                                 writer_of(participant, info_type, rig, "/right/camera_info")};
  const dds_entity_t points =
      writer_of(participant, &sensor_msgs_msg_dds__PointCloud2__desc, rig, "/points");
  sensor_msgs_msg_dds__PointCloud2_ wall = wall_of(width, height);
  sensor_msgs_msg_dds__Image_ image = {0};
  image.header.frame_id = "camera";
  image.width = width;
  image.height = height;
  image.encoding = "mono8";
  image.step = width;
  image.data._length = image.data._maximum = width * height;
  image.data._buffer = malloc((size_t)width * height);
  const int64_t begin = now_us();
  for (int i = 0; i < frames; ++i) {
    sleep_us(begin + (int64_t)(i * 1e6 / hz) - now_us());
    const int64_t stamp = now_us();
    for (int side = 0; side < 2; ++side) {
      sensor_msgs_msg_dds__CameraInfo_ info = info_of(width, height, side == 0 ? 0 : -100);
      image.header.stamp.sec = info.header.stamp.sec = (int32_t)(stamp / 1000000);
      image.header.stamp.nanosec = info.header.stamp.nanosec =
          (uint32_t)(stamp % 1000000) * 1000;
      memset(image.data._buffer, i % 251 + side, (size_t)width * height);
      dds_write(infos[side], &info);
      dds_write(images[side], &image);
    }
    wall.header.stamp = image.header.stamp;
    dds_write(points, &wall);
  }
  printf("sent %d\n", frames);
  return 0;
}

static int send_text(dds_entity_t participant, char** argv) {
  const dds_entity_t writer =
      writer_of(participant, &std_msgs_msg_dds__String__desc, argv[0], "");
  std_msgs_msg_dds__String_ text = {"no image"};
  for (int i = 0; i < 10 * atoi(argv[1]); ++i) {
    dds_write(writer, &text);
    sleep_us(100000);
  }
  return 0;
}

struct heard {
  const char* topic;
  dds_entity_t reader;
  bool is_image;
  long messages;
  long long bytes;
  int64_t first_us, last_us;
};

static void take(struct heard* one) {
  void* samples[1] = {NULL};
  dds_sample_info_t info;
  while (dds_take(one->reader, samples, &info, 1, 1) == 1) {
    if (info.valid_data) {
      const sensor_msgs_msg_dds__Image_* image = samples[0];
      const sensor_msgs_msg_dds__PointCloud2_* points = samples[0];
      one->bytes += one->is_image ? image->data._length : points->data._length;
      one->last_us = now_us();
      if (one->messages++ == 0) one->first_us = one->last_us;
    }
    dds_return_loan(one->reader, samples, 1);
  }
}

static int hear(dds_entity_t participant, int argc, char** argv) {
  signal(SIGTERM, on_signal);
  const double seconds = atof(argv[0]), asleep = atof(argv[1]);
  struct heard all[MOST] = {{0}};
  const int count = argc - 3 < MOST ? argc - 3 : MOST;
  for (int i = 0; i < count; ++i) {
    all[i].topic = strtok(argv[3 + i], "=");
    all[i].is_image = strcmp(strtok(NULL, "="), "image") == 0;
    const dds_topic_descriptor_t* type = all[i].is_image ? &sensor_msgs_msg_dds__Image__desc
                                                         : &sensor_msgs_msg_dds__PointCloud2__desc;
    all[i].reader = dds_create_reader(participant, topic_of(participant, type, all[i].topic),
                                      qos_of(atoi(argv[2]) != 0), NULL);
  }
  sleep_us((int64_t)(asleep * 1e6));
  const int64_t end = now_us() + (int64_t)(seconds * 1e6);
  while (now_us() < end && !has_to_end) {
    for (int i = 0; i < count; ++i) take(&all[i]);
    sleep_us(2000);
  }
  for (int i = 0; i < count; ++i) {
    dds_sample_lost_status_t lost = {0};
    dds_get_sample_lost_status(all[i].reader, &lost);
    printf("%s %ld messages %lld bytes %.2f s %u lost\n", all[i].topic, all[i].messages,
           all[i].bytes, (double)(all[i].last_us - all[i].first_us) / 1e6, lost.total_count);
  }
  return 0;
}

int main(int argc, char** argv) {
  const char* more = getenv("CYCLONEDDS_URI");
  char config[1024];
  snprintf(config, sizeof config,
           "<CycloneDDS><Domain id=\"any\"><Internal><SocketReceiveBufferSize max=\"32MB\"/>"
           "</Internal></Domain></CycloneDDS>%s%s",
           more ? "," : "", more ? more : "");
  dds_create_domain(0, config);
  const dds_entity_t participant = dds_create_participant(0, NULL, NULL);
  int result = 2;
  if (participant > 0 && argc == 7 && strcmp(argv[1], "send") == 0) result = send_rig(participant, argv + 2);
  if (participant > 0 && argc == 4 && strcmp(argv[1], "send_text") == 0) result = send_text(participant, argv + 2);
  if (participant > 0 && argc > 5 && strcmp(argv[1], "hear") == 0) result = hear(participant, argc - 2, argv + 2);
  // Not dds_delete(), which waits for readers that are gone.
  fflush(stdout);
  _Exit(result);
}
