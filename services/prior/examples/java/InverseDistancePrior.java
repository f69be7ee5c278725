/**
 * The method, without a word of messages: each pixel takes the mean of its nearest seeds'
 * disparities, weighted by inverse squared distance (Shepard, 1968).
 *
 * <p>Same seeds, same bytes: no clock, no threads, ties go to the seed that came first.
 */
final class InverseDistancePrior {
  static final int COUNTS_PER_PX = 32;
  static final short INVALID = Short.MIN_VALUE;
  private static final int NEAREST = 4;

  private final int width;
  private final int height;
  // Positions in the left image and disparities, px, of the seeds in the image.
  private final float[] u;
  private final float[] v;
  private final float[] disparity;
  private final int count;
  // Seeds by square cell of the image: those of cell c are order[start[c]] to order[start[c + 1]].
  private final float cell;
  private final int columns;
  private final int rows;
  private final int[] start;
  private final int[] order;
  // The nearest seeds of the pixel in hand, nearest first.
  private final float[] distances = new float[NEAREST];
  private final int[] found = new int[NEAREST];
  private int foundCount;

  /**
   * @param seedU column of each seed in the left image, px
   * @param seedV its row
   * @param seedURight its column in the right image
   * @param width of the left image, px
   * @param height of the left image, px
   */
  InverseDistancePrior(float[] seedU, float[] seedV, float[] seedURight, int width, int height) {
    this.width = width;
    this.height = height;
    u = new float[seedU.length];
    v = new float[seedU.length];
    disparity = new float[seedU.length];
    int kept = 0;
    for (int i = 0; i < seedU.length; ++i) {
      boolean inside =
          seedU[i] >= 0 && seedU[i] <= width - 1 && seedV[i] >= 0 && seedV[i] <= height - 1;
      if (!inside || seedU[i] < seedURight[i]) continue;
      u[kept] = seedU[i];
      v[kept] = seedV[i];
      disparity[kept++] = seedU[i] - seedURight[i];
    }
    count = kept;
    cell = (float) Math.max(1, Math.sqrt((double) width * height / Math.max(1, count)));
    columns = (int) (width / cell) + 1;
    rows = (int) (height / cell) + 1;
    start = new int[columns * rows + 1];
    order = new int[count];
    sortIntoCells();
  }

  /** The map, row by row, in counts of 1/32 px; all INVALID without seeds. */
  short[] compute() {
    short[] map = new short[width * height];
    for (int row = 0; row < height; ++row) {
      for (int column = 0; column < width; ++column) {
        map[row * width + column] = count == 0 ? INVALID : at(column, row);
      }
    }
    return map;
  }

  private int cellOf(int seed) {
    return (int) (v[seed] / cell) * columns + (int) (u[seed] / cell);
  }

  private void sortIntoCells() {
    for (int i = 0; i < count; ++i) ++start[cellOf(i) + 1];
    for (int c = 0; c < columns * rows; ++c) start[c + 1] += start[c];
    int[] next = start.clone();
    for (int i = 0; i < count; ++i) order[next[cellOf(i)]++] = i;
  }

  private short at(int column, int row) {
    findNearest(column, row);
    float sum = 0;
    float weights = 0;
    for (int i = 0; i < foundCount; ++i) {
      float weight = 1 / (distances[i] + 0.25f); // a seed on the pixel has no endless weight
      sum += weight * disparity[found[i]];
      weights += weight;
    }
    return (short) Math.min(Short.MAX_VALUE, Math.round(sum / weights * COUNTS_PER_PX));
  }

  // Looks at rings of cells around the pixel until none further out can be nearer.
  private void findNearest(int column, int row) {
    foundCount = 0;
    int centreX = (int) (column / cell);
    int centreY = (int) (row / cell);
    for (int ring = 0; ring <= Math.max(columns, rows); ++ring) {
      for (int y = centreY - ring; y <= centreY + ring; ++y) {
        boolean edgeRow = y == centreY - ring || y == centreY + ring;
        for (int x = centreX - ring; x <= centreX + ring; x += edgeRow || ring == 0 ? 1 : 2 * ring) {
          lookInto(x, y, column, row);
        }
      }
      float safe = ring * cell; // every seed nearer than this has been seen
      if (foundCount == NEAREST && distances[NEAREST - 1] <= safe * safe) return;
    }
  }

  private void lookInto(int x, int y, int column, int row) {
    if (x < 0 || y < 0 || x >= columns || y >= rows) return;
    int c = y * columns + x;
    for (int i = start[c]; i < start[c + 1]; ++i) {
      int seed = order[i];
      float du = u[seed] - column;
      float dv = v[seed] - row;
      insert(seed, du * du + dv * dv);
    }
  }

  private void insert(int seed, float distance) {
    if (foundCount == NEAREST && distance >= distances[NEAREST - 1]) return;
    int place = foundCount < NEAREST ? foundCount++ : NEAREST - 1;
    for (; place > 0 && distances[place - 1] > distance; --place) {
      distances[place] = distances[place - 1];
      found[place] = found[place - 1];
    }
    distances[place] = distance;
    found[place] = seed;
  }
}
