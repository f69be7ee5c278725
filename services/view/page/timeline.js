// The time line: a slider over the frames, and above it, for a log, thumbnails and the quality.

const kThumbnail = 104;  // px, with its gap

export class TimeLine {
  constructor(look) {
    this.slider = document.getElementById('slider');
    this.canvas = document.getElementById('quality');
    this.place = document.getElementById('place');
    this.images = new Map();  // thumbnails by key
    this.slider.oninput = () => look(Number(this.slider.value));
    this.canvas.onclick = (event) => {
      const bucket = this.bucketAt(event);
      if (bucket) look(bucket.key);
    };
    this.canvas.onmousemove = (event) => {
      const bucket = this.bucketAt(event);
      this.canvas.title = !bucket ? '' : `frame ${bucket.seq}` +
          (bucket.why ? `: ${bucket.why}` : ', not rated yet');
    };
  }

  /// Sets the range of frames that can be shown, and the one on show.
  set([first, last], key, live) {
    if (last < first) return;
    Object.assign(this.slider, {min: first, max: last, value: key});
    const behind = last - key;
    this.place.textContent = this.isLog ? `${key + 1} of ${last + 1}` :
        live ? `newest of ${last - first + 1}` : `${behind} before the newest`;
    this.key = key;
    if (this.line) this.draw();
  }

  /// Shows the time line of a log, and updates it until the log is read and rated.
  async follow() {
    this.isLog = true;
    this.canvas.hidden = false;
    try {
      const width = Math.max(1, Math.min(600, Math.floor(this.canvas.clientWidth / 3)));
      this.line = await (await fetch(`timeline?buckets=${width}`)).json();
      this.draw();
    } catch {
      // the server is away; the next time
    }
    const settled = this.line?.complete && this.line.settled;
    clearTimeout(this.timer);
    if (!settled) this.timer = setTimeout(() => this.follow(), 1000);
  }

  bucketAt(event) {
    const count = this.line?.buckets.length;
    return count ? this.line.buckets[Math.min(count - 1, Math.floor(event.offsetX / this.canvas.clientWidth * count))] : undefined;
  }

  draw() {
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight].map((side) => side * devicePixelRatio);
    [this.canvas.width, this.canvas.height] = [width, height];
    const context = this.canvas.getContext('2d');
    const {buckets} = this.line;
    if (!buckets.length) return;
    const bars = 26 * devicePixelRatio;
    this.drawThumbnails(context, width, height - bars - 2);
    const step = width / buckets.length;
    // Quality depends on scene and cameras, so colours compare the frames with each other.
    const rated = buckets.map((bucket) => bucket.quality).filter((quality) => quality !== undefined);
    const usual = rated.sort((a, b) => a - b)[rated.length >> 1];
    buckets.forEach(({quality}, i) => {
      context.fillStyle = quality === undefined ? '#2b3137' : quality < 0.6 * usual ? '#e0705f' : quality < 0.85 * usual ? '#d9a648' : '#6fb3a8';
      const share = quality === undefined ? 0.1 : Math.max(0.08, quality);
      context.fillRect(i * step, height - share * bars, Math.max(1, step - 1), share * bars);
    });
    const {first, last} = this.line;
    const x = (this.key - first + 0.5) / (last - first + 1) * width;
    context.fillStyle = '#fff';
    context.fillRect(x - 1, 0, 2, height);
  }

  drawThumbnails(context, width, height) {
    const count = Math.max(1, Math.floor(width / (kThumbnail * devicePixelRatio)));
    const {buckets} = this.line;
    for (let i = 0; i < count; ++i) {
      const {key} = buckets[Math.floor((i + 0.5) / count * buckets.length)];
      const image = this.images.get(key);
      if (!image) this.load(key);
      if (!image?.complete || !image.naturalWidth) continue;
      const slot = width / count;
      const scale = Math.min((slot - 4) / image.naturalWidth, height / image.naturalHeight);
      const [w, h] = [image.naturalWidth * scale, image.naturalHeight * scale];
      context.drawImage(image, i * slot + (slot - w) / 2, (height - h) / 2, w, h);
    }
  }

  load(key) {
    const image = new Image();
    image.onload = () => this.draw();
    image.src = `thumb?key=${key}`;
    this.images.set(key, image);
    if (this.images.size > 200) this.images.delete(this.images.keys().next().value);
  }
}
