// Where the names of a figure's points stand: beside their points, and none over another.

export interface LabelBox {
  x: number;
  y: number;
  width: number;
  height: number;
}

interface Point {
  x: number;
  y: number;
}

const kGap = 11;

const overlap = (a: LabelBox, b: LabelBox): boolean => a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;
const clamp = (value: number, low: number, high: number) => Math.min(Math.max(value, low), Math.max(low, high));

/**
 * A box for each point's label, of the given widths and one height, within `room`. Each stands right of its point, or left
 * of it where there is more room, at the height nearest to its point's that no other label has; no label covers a point.
 */
export function labelPlaces(points: Point[], widths: number[], height: number, room: LabelBox): LabelBox[] {
  const taken: LabelBox[] = points.map(({ x, y }) => ({ x: x - 5, y: y - 5, width: 10, height: 10 }));
  return points.map(({ x, y }, i) => {
    const width = widths[i]!;
    const right = room.x + room.width - width;
    const sides = [...new Set([x + kGap, x - kGap - width].map((left) => clamp(left, room.x, right)))];
    if (x + kGap > right) sides.reverse();
    const down = Math.ceil(room.height / height) * 2;
    for (let step = 0; step <= 2 * down; ++step) {
      const off = (Math.ceil(step / 2) * height * (step % 2 ? -1 : 1)) / 2;
      const top = y - height / 2 + off;
      if (top < room.y || top + height > room.y + room.height) continue;
      for (const left of sides) {
        const box = { x: left, y: top, width, height };
        if (taken.some((other) => overlap(box, other))) continue;
        taken.push(box);
        return box;
      }
    }
    const box = { x: sides[0]!, y: clamp(y - height / 2, room.y, room.y + room.height - height), width, height };
    taken.push(box);
    return box;
  });
}
