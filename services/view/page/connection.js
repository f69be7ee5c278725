// The WebSocket: sends what the page wants, takes frames apart, and reconnects by itself.

const kFirstWait = 300;  // ms until it is tried again; doubled up to the longest
const kLongestWait = 3000;
const kMaxSilence = 5;  // s; the server says something every second

/// A packet as packet.h makes it: head, and the body of each part.
export function readPacket(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  const start = 4 + length;
  for (const part of head.parts) {
    part.buffer = buffer;
    part.start = start + part.offset;
  }
  return head;
}

/// Why the server refuses a page, in its own words; empty when nobody answers, or nothing is wrong.
async function refusal() {
  try {
    const answer = await fetch('/ws', {signal: AbortSignal.timeout(kMaxSilence * 1000)});
    return answer.ok ? '' : (await answer.text()).trim();
  } catch {
    return '';
  }
}

/// Calls handlers.open(), .closed(), .refused(why), .frame(head), and .text(message) for everything
/// else.
export class Connection {
  constructor(handlers) {
    this.handlers = handlers;
    this.wait = kFirstWait;
    this.open();
    setInterval(() => this.watch(), 1000);
  }

  // Nobody tells of a connection that died while this machine slept, or without its cable. Seconds
  // that the page slept do not count: what came meanwhile is still to be read.
  watch() {
    if (this.socket.readyState > WebSocket.OPEN || ++this.silence < kMaxSilence) return;
    this.socket.onopen = this.socket.onmessage = this.socket.onclose = null;
    this.socket.close();
    this.handlers.closed();
    this.open();
  }

  open() {
    this.socket = new WebSocket(`ws://${location.host}/ws`);
    let opened = false;
    this.socket.binaryType = 'arraybuffer';
    this.silence = 0;
    this.socket.onopen = () => {
      opened = true;
      this.wait = kFirstWait;
      this.handlers.open();
    };
    this.socket.onmessage = ({data}) => {
      this.silence = 0;
      if (typeof data === 'string') this.handlers.text(JSON.parse(data));
      else this.handlers.frame(readPacket(data));
    };
    this.socket.onclose = () => {
      if (opened) this.handlers.closed();
      else this.tellWhy();
      setTimeout(() => this.open(), this.wait);
      this.wait = Math.min(2 * this.wait, kLongestWait);
    };
  }

  // For a socket that did not open: the browser does not tell whether it was refused.
  async tellWhy() {
    const why = await refusal();
    if (this.socket.readyState === WebSocket.OPEN) return;  // meanwhile
    if (why) this.handlers.refused(why);
    else this.handlers.closed();
  }

  send(message) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }
}
