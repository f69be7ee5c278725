import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.util.HashMap;
import java.util.Map;
import java.util.concurrent.ArrayBlockingQueue;
import java.util.concurrent.BlockingQueue;
import java.util.function.Predicate;
import lcm.lcm.LCM;
import lcm.lcm.LCMDataInputStream;
import lcm.lcm.ReceiveBuffer;
import sprout.header_t;
import sprout.image_t;
import sprout.prior_t;
import sprout.rig_t;
import sprout.seeds_t;

/**
 * The plug: LEFT, SEEDS and RIG in, PRIOR out. LCM's thread receives and joins, the main thread
 * computes and answers, and between them lies the newest frame only.
 *
 * <p>Of LEFT only the size is used: an answer has as many pixels as the image that it answers, never
 * as many as the few bytes of a calibration claim.
 */
final class PriorStage {
  private static final int RECEIVE_BUFFER_BYTES = 64 << 20; // some frames of 2 MP

  private static final int MOST_PENDING = 16;
  // How far the prior may be off, px. This method does not know better: a constant that is about
  // right beside a seed, and too small between seeds that lie far apart.
  private static final int SIGMA_PX = 1;
  private static final int SIGMA_COUNTS_PER_PX = 16;
  private static final int NO_SIGMA = 255; // where there is no disparity

  private record Key(long utime, long seq, String rigId) {}

  private record Frame(seeds_t seeds, int width, int height, boolean calibrated) {}

  // What has come of a frame so far.
  private static final class Parts {
    seeds_t seeds;
    image_t left;
  }

  private final LCM lcm;
  private final StatusReporter status;
  private final BlockingQueue<Frame> newest = new ArrayBlockingQueue<>(1);
  private rig_t rig; // LCM's thread only, as is:
  private final Map<Key, Parts> pending = new HashMap<>();

  public static void main(String[] args) throws IOException, InterruptedException {
    // Without an argument LCM looks into LCM_DEFAULT_URL by itself.
    LCM lcm = args.length == 0 ? new LCM() : new LCM(args);
    ReceiveBuffer.request(lcm, RECEIVE_BUFFER_BYTES);
    new PriorStage(lcm).work();
  }

  private PriorStage(LCM lcm) {
    this.lcm = lcm;
    status = new StatusReporter(lcm, "prior");
    lcm.subscribe("SPROUT_(LEFT|SEEDS|RIG)", this::receive);
    status.start();
  }

  // An exception that gets out of here ends LCM's thread, and the program would be deaf.
  private void receive(LCM from, String channel, LCMDataInputStream in) {
    try {
      byte[] bytes = new byte[in.available()];
      in.readFully(bytes);
      switch (channel) {
        case "SPROUT_RIG" -> rig = Border.rig(bytes);
        case "SPROUT_LEFT" -> {
          image_t left = Border.left(bytes);
          partsOf(left.header).left = left;
          join(left.header);
        }
        default -> {
          seeds_t seeds = Border.seeds(bytes);
          partsOf(seeds.header).seeds = seeds;
          join(seeds.header);
        }
      }
    } catch (IOException | RuntimeException e) {
      status.badMessage(channel + ": " + e.getMessage());
    }
  }

  private static Key keyOf(header_t header) {
    return new Key(header.utime, header.seq, header.rig_id);
  }

  private Parts partsOf(header_t header) {
    Key key = keyOf(header);
    // Whoever sends halves of frames without end gets no more memory than this.
    if (!pending.containsKey(key) && pending.size() >= MOST_PENDING) drop(any -> true);
    return pending.computeIfAbsent(key, unused -> new Parts());
  }

  private void drop(Predicate<Key> which) {
    for (Key key : pending.keySet()) {
      if (which.test(key)) status.incomplete("frame " + key.seq() + ": LEFT or SEEDS never came");
    }
    pending.keySet().removeIf(which);
  }

  private void join(header_t header) {
    Key key = keyOf(header);
    Parts parts = pending.get(key);
    if (parts.seeds == null || parts.left == null) return;
    pending.remove(key);
    drop(other -> other.utime() < header.utime); // a newer one is complete
    // The calibration comes once a second and holds for every frame that names it.
    if (rig == null || !rig.header.rig_id.equals(header.rig_id)) {
      status.incomplete("frame " + header.seq + ": no calibration " + header.rig_id + " yet");
      return;
    }
    boolean calibrated = parts.left.width == rig.width && parts.left.height == rig.height;
    boolean skipped = newest.poll() != null;
    newest.offer(new Frame(parts.seeds, parts.left.width, parts.left.height, calibrated));
    status.frameIn(skipped);
  }

  private void work() throws InterruptedException {
    while (true) {
      Frame frame = newest.take();
      lcm.publish("SPROUT_PRIOR", answer(frame));
      status.frameOut(frame.seeds.header);
    }
  }

  private static prior_t answer(Frame frame) {
    float[] none = {};
    // Seeds of images of another size than the calibrated one lie anywhere.
    seeds_t seeds = frame.seeds;
    short[] map =
        new InverseDistancePrior(
                frame.calibrated ? seeds.u : none,
                frame.calibrated ? seeds.v : none,
                frame.calibrated ? seeds.u_right : none,
                frame.width,
                frame.height)
            .compute();
    prior_t message = new prior_t();
    message.header = seeds.header; // passed on as it is
    message.width = frame.width;
    message.height = frame.height;
    message.encoding = prior_t.ENCODING_RAW;
    message.counts_per_px = InverseDistancePrior.COUNTS_PER_PX;
    message.invalid = InverseDistancePrior.INVALID;
    message.size = map.length * Short.BYTES;
    message.data = new byte[message.size];
    ByteBuffer.wrap(message.data).order(ByteOrder.LITTLE_ENDIAN).asShortBuffer().put(map);
    message.sigma_counts_per_px = SIGMA_COUNTS_PER_PX;
    message.sigma_size = map.length;
    message.sigma = new byte[message.sigma_size];
    for (int i = 0; i < map.length; ++i) {
      boolean unknown = map[i] == InverseDistancePrior.INVALID;
      message.sigma[i] = (byte) (unknown ? NO_SIGMA : SIGMA_PX * SIGMA_COUNTS_PER_PX);
    }
    return message;
  }
}
