// Seeds as dots over the left image, coloured by their disparity. Those of stereo are hollow, so
// that one sees where the ToF camera saw nothing.

const kStereo = 1;

export function drawSeeds(canvas, part, [width, height], scale, colors) {
  const box = canvas.parentElement;
  const shrink = Math.min(1, box.clientWidth * devicePixelRatio / width);
  canvas.width = Math.round(width * shrink);
  canvas.height = Math.round(height * shrink);
  const {buffer, start, count} = part;
  const us = new Int16Array(buffer, start, count);
  const vs = new Int16Array(buffer, start + 2 * count, count);
  const disparities = new Int16Array(buffer, start + 4 * count, count);
  const kinds = new Uint8Array(buffer, start + 6 * count, count);
  // Few seeds get large dots, many get small ones, so that the image stays visible.
  const side = Math.max(1, Math.min(7, Math.round(0.35 * Math.sqrt(canvas.width * canvas.height / (count + 1)))));
  const context = canvas.getContext('2d');
  const image = context.createImageData(canvas.width, canvas.height);
  const pixels = new Uint32Array(image.data.buffer);
  for (let i = 0; i < count; ++i) {
    const [r, g, b] = colors.of(disparities[i] / part.counts_per_px, scale);
    const color = (255 << 24 | b << 16 | g << 8 | r) >>> 0;
    const left = Math.round(us[i] * shrink - side / 2);
    const top = Math.round(vs[i] * shrink - side / 2);
    const hollow = kinds[i] === kStereo && side > 2;
    for (let y = Math.max(0, top); y < Math.min(canvas.height, top + side); ++y) {
      for (let x = Math.max(0, left); x < Math.min(canvas.width, left + side); ++x) {
        const inside = x > left && x < left + side - 1 && y > top && y < top + side - 1;
        if (!(hollow && inside)) pixels[y * canvas.width + x] = color;
      }
    }
  }
  context.putImageData(image, 0, 0);
}
