package lcm.lcm;

import java.net.SocketException;

/**
 * Asks the kernel for a larger receive buffer, for which lcm.jar has no option: it ignores
 * recv_buf_size in the URL. On udpm every program gets every message of the graph, and with the
 * kernel's default of 200 kB the images push out the seeds. In LCM's package for the sake of its
 * fields.
 */
public final class ReceiveBuffer {
  private ReceiveBuffer() {}

  /** The kernel grants at most net.core.rmem_max; scripts/setup raises that to 64 MB. */
  public static void request(LCM lcm, int bytes) throws SocketException {
    for (Provider provider : lcm.providers) {
      if (provider instanceof UDPMulticastProvider udpm) udpm.sock.setReceiveBufferSize(bytes);
    }
  }
}
