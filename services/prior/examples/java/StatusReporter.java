import java.net.InetAddress;
import java.net.UnknownHostException;
import lcm.lcm.LCM;
import sprout.header_t;
import sprout.stage_status_t;

/** Counts what happens and says so on SPROUT_STATUS, at once and then once a second. */
final class StatusReporter {
  private final LCM lcm;
  private final stage_status_t status = new stage_status_t();

  StatusReporter(LCM lcm, String stage) {
    this.lcm = lcm;
    status.header = new header_t();
    status.header.seq = -1; // no frame yet
    status.header.rig_id = "";
    status.stage = stage;
    status.host = hostName();
    status.version = "example in Java";
    status.config_digest = "";
    status.last_error = "";
    status.pid = (int) ProcessHandle.current().pid();
    status.state = stage_status_t.STATE_READY;
    status.tof_coverage = -1; // not known: not looked for here
    status.spread_ms = -1;
    status.tof_offset_sigma_px = -1;
  }

  void start() {
    Thread thread = new Thread(this::run, "status");
    thread.setDaemon(true);
    thread.start();
  }

  synchronized void frameIn(boolean skipped) {
    ++status.frames_in;
    if (skipped) ++status.frames_skipped;
  }

  synchronized void frameOut(header_t header) {
    ++status.frames_out;
    status.header = header;
    status.state = stage_status_t.STATE_RUNNING;
  }

  synchronized void incomplete(String reason) {
    ++status.frames_incomplete;
    status.last_error = reason;
  }

  synchronized void badMessage(String reason) {
    ++status.bad_messages;
    status.last_error = reason;
  }

  private synchronized void publish() {
    Runtime runtime = Runtime.getRuntime();
    status.rss_bytes = runtime.totalMemory() - runtime.freeMemory(); // of the heap
    lcm.publish("SPROUT_STATUS", status);
  }

  private void run() {
    try {
      while (true) {
        publish();
        Thread.sleep(1000);
      }
    } catch (InterruptedException e) {
      Thread.currentThread().interrupt();
    }
  }

  private static String hostName() {
    try {
      return InetAddress.getLocalHost().getHostName();
    } catch (UnknownHostException e) {
      return "";
    }
  }
}
