import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.util.concurrent.ArrayBlockingQueue;
import java.util.concurrent.BlockingQueue;
import lcm.lcm.LCM;
import lcm.lcm.LCMDataInputStream;
import lcm.lcm.ReceiveBuffer;
import sprout.disparity_image_t;
import sprout.rig_t;
import sprout.seeds_t;

/**
 * The plug: SEEDS and RIG in, PRIOR out. LCM's thread receives and joins, the main thread computes
 * and answers, and between them lies the newest frame only.
 */
final class PriorStage {
  private static final int RECEIVE_BUFFER_BYTES = 64 << 20; // some frames of 2 MP

  private record Frame(seeds_t seeds, int width, int height) {}

  private final LCM lcm;
  private final StatusReporter status;
  private final BlockingQueue<Frame> newest = new ArrayBlockingQueue<>(1);
  private rig_t rig; // LCM's thread only

  public static void main(String[] args) throws IOException, InterruptedException {
    // Without an argument LCM looks into LCM_DEFAULT_URL by itself.
    LCM lcm = args.length == 0 ? new LCM() : new LCM(args);
    ReceiveBuffer.request(lcm, RECEIVE_BUFFER_BYTES);
    new PriorStage(lcm).work();
  }

  private PriorStage(LCM lcm) {
    this.lcm = lcm;
    status = new StatusReporter(lcm, "prior");
    lcm.subscribe("SPROUT_(SEEDS|RIG)", this::receive);
    status.start();
  }

  // An exception that gets out of here ends LCM's thread, and the program would be deaf.
  private void receive(LCM from, String channel, LCMDataInputStream in) {
    try {
      byte[] bytes = new byte[in.available()];
      in.readFully(bytes);
      if (channel.equals("SPROUT_RIG")) {
        rig = Border.rig(bytes);
      } else {
        join(Border.seeds(bytes));
      }
    } catch (IOException | RuntimeException e) {
      status.badMessage(channel + ": " + e.getMessage());
    }
  }

  private void join(seeds_t seeds) {
    // The calibration comes once a second and holds for every frame that names it.
    if (rig == null || !rig.header.rig_id.equals(seeds.header.rig_id)) {
      status.incomplete(seeds.header);
      return;
    }
    boolean skipped = newest.poll() != null;
    newest.offer(new Frame(seeds, rig.width, rig.height));
    status.frameIn(skipped);
  }

  private void work() throws InterruptedException {
    while (true) {
      Frame frame = newest.take();
      lcm.publish("SPROUT_PRIOR", answer(frame));
      status.frameOut(frame.seeds.header);
    }
  }

  private static disparity_image_t answer(Frame frame) {
    short[] map =
        new InverseDistancePrior(
                frame.seeds.u, frame.seeds.v, frame.seeds.u_right, frame.width, frame.height)
            .compute();
    disparity_image_t message = new disparity_image_t();
    message.header = frame.seeds.header; // passed on as it is
    message.width = frame.width;
    message.height = frame.height;
    message.encoding = disparity_image_t.ENCODING_RAW_INT16;
    message.counts_per_px = InverseDistancePrior.COUNTS_PER_PX;
    message.invalid = InverseDistancePrior.INVALID;
    message.size = map.length * Short.BYTES;
    message.data = new byte[message.size];
    ByteBuffer.wrap(message.data).order(ByteOrder.LITTLE_ENDIAN).asShortBuffer().put(map);
    return message;
  }
}
