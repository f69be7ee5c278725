import java.io.IOException;
import java.nio.ByteBuffer;
import sprout.image_t;
import sprout.rig_t;
import sprout.seeds_t;

/**
 * The border guard: bytes in, messages that can be relied on out. Generated decoders believe every
 * count in a message and take memory for it before they look whether the bytes are there, so counts
 * are compared with the length first. All types of Sprout have them between header and first array.
 */
final class Border {
  private static final int MAX_SIDE = 16384; // px, as in lcmtypes
  private static final long MAX_PIXELS = 100_000_000; // as in common/messages
  private static final long MAX_JPEG_PIXELS_A_BYTE = 512;
  private static final int RIG_ID = 24; // behind the fingerprint, utime and seq, 8 bytes each
  private static final int MAX_RIG_ID = 64;
  // u, v, u_right and sigma_px; origin; tof_u and tof_v
  private static final int SEED_BYTES = 4 * Float.BYTES + Byte.BYTES + 2 * Short.BYTES;
  private static final float MAX_SIGMA_PX = 1023;

  private Border() {}

  static seeds_t seeds(byte[] bytes) throws IOException {
    int body = bodyOf(bytes);
    int arrays = body + 8 * Integer.BYTES; // count and seven others
    require(bytes.length >= arrays, "cut short");
    long count = ByteBuffer.wrap(bytes).getInt(body);
    require(count >= 0 && arrays + count * SEED_BYTES == bytes.length, "count = " + count);
    seeds_t message = new seeds_t(bytes);
    requireHeader(message.header);
    for (int i = 0; i < message.count; ++i) {
      require(
          isPosition(message.u[i]) && isPosition(message.v[i]) && isPosition(message.u_right[i]),
          "the position of seed " + i);
      requireOrigin(message, i);
    }
    return message;
  }

  private static void requireOrigin(seeds_t message, int i) throws IOException {
    float sigma = message.sigma_px[i];
    require(sigma > 0 && sigma <= MAX_SIGMA_PX, "sigma_px of seed " + i); // false for NaN as well
    byte origin = message.origin[i];
    boolean stereo = origin == seeds_t.ORIGIN_STEREO;
    require(stereo || origin == seeds_t.ORIGIN_TOF, "origin of seed " + i);
    short u = message.tof_u[i];
    short v = message.tof_v[i];
    boolean none = u == -1 && v == -1;
    boolean pixel = u >= 0 && u < MAX_SIDE && v >= 0 && v < MAX_SIDE;
    require(none || (pixel && !stereo), "the ToF pixel of seed " + i);
  }

  /** Without its pixels, which this method does not look at. */
  static image_t left(byte[] bytes) throws IOException {
    int body = bodyOf(bytes);
    int data = body + 5 * Integer.BYTES; // behind width, height, row_stride, pixel_format, size
    require(bytes.length >= data, "cut short");
    long size = ByteBuffer.wrap(bytes).getInt(body + 4 * Integer.BYTES);
    require(size >= 0 && data + size == bytes.length, "size = " + size);
    image_t message = new image_t(bytes);
    requireHeader(message.header);
    requireSize(message.width, message.height);
    boolean jpeg = message.pixel_format == image_t.PIXEL_FORMAT_MJPG;
    boolean grey = message.pixel_format == image_t.PIXEL_FORMAT_GREY;
    boolean colour =
        message.pixel_format == image_t.PIXEL_FORMAT_RGB3
            || message.pixel_format == image_t.PIXEL_FORMAT_BGR3;
    require(jpeg || grey || colour, "pixel_format = " + message.pixel_format);
    long pixels = (long) message.width * message.height;
    if (jpeg) {
      // The answer is as large as the picture says that it is: no more than a JPEG can hold.
      require(pixels <= MAX_JPEG_PIXELS_A_BYTE * size, "width x height");
    } else {
      long rowBytes = (long) message.width * (grey ? 1 : 3);
      require(message.row_stride >= rowBytes, "row_stride = " + message.row_stride);
      require((long) message.row_stride * message.height == size, "size = " + size);
    }
    message.data = null;
    return message;
  }

  static rig_t rig(byte[] bytes) throws IOException {
    bodyOf(bytes);
    rig_t message = new rig_t(bytes);
    requireHeader(message.header);
    requireSize(message.width, message.height);
    // Checked although this method needs only the size: who trusts half of a message is the next
    // one's problem.
    require(Double.isFinite(message.focal_px) && message.focal_px > 0, "focal_px");
    return message;
  }

  // Offset of the first byte behind the header.
  private static int bodyOf(byte[] bytes) throws IOException {
    require(bytes.length >= RIG_ID + Integer.BYTES, "cut short");
    int length = ByteBuffer.wrap(bytes).getInt(RIG_ID); // with the closing zero
    require(length >= 1 && length <= MAX_RIG_ID + 1, "the length of header.rig_id");
    return RIG_ID + Integer.BYTES + length;
  }

  private static void requireSize(int width, int height) throws IOException {
    require(width >= 1 && width <= MAX_SIDE, "width = " + width);
    require(height >= 1 && height <= MAX_SIDE, "height = " + height);
    // A few bytes must not ask for gigabytes.
    require((long) width * height <= MAX_PIXELS, "width x height");
  }

  private static void requireHeader(sprout.header_t header) throws IOException {
    require(header.utime >= 0, "header.utime = " + header.utime);
    require(header.seq >= 0, "header.seq = " + header.seq);
  }

  private static boolean isPosition(float px) {
    return Math.abs(px) <= MAX_SIDE; // false for NaN as well
  }

  private static void require(boolean holds, String what) throws IOException {
    if (!holds) throw new IOException(what + " is not allowed");
  }
}
