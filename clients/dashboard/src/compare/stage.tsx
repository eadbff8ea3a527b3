// The pictures: a canvas that is drawn anew only when what it shows has changed, and what the pointer does on it.

import { effect } from "@preact/signals";
import { useEffect, useRef, useState } from "preact/hooks";

import { isDark } from "../app/theme";
import { cropBetween, kMaxCrops } from "./crops";
import type { Desk, Pane } from "./desk";
import { Developer } from "./gl_develop";
import { Overlay } from "./overlay";
import { present, type Piece } from "./present";
import { imagePoint, panned, zoomedAt, type Point } from "./view";

const kClickPixels = 4;

function piecesOf(desk: Desk): Piece[] {
  const view = desk.view.value;
  const shown = desk.shown.value;
  return desk.panes.value.flatMap(({ index, box, clip }) => {
    const picture = shown[index]?.picture;
    return picture ? [{ picture, view, pane: box, clip }] : [];
  });
}

/** Draws at once, so that the canvas is as what it shows. */
export function drawNow(desk: Desk, canvas: HTMLCanvasElement): void {
  const developer = desk.developer.peek();
  const context = canvas.getContext("2d", { alpha: false });
  if (developer && context) present(context, developer, getComputedStyle(canvas).backgroundColor, piecesOf(desk));
}

/** What a place of the stage is of: the pane, and the place of its image. Device pixels. */
function under(desk: Desk, at: Point): { pane: Pane; place: Point; inPane: Point } | null {
  const inside = (box: Pane["box"]) => at.x >= box.x && at.y >= box.y && at.x < box.x + box.width && at.y < box.y + box.height;
  const pane = desk.panes.peek().find((one) => inside(one.clip)) ?? null;
  if (!pane) return null;
  const inPane = { x: at.x - pane.box.x, y: at.y - pane.box.y };
  return { pane, inPane, place: imagePoint(desk.view.peek(), pane.box, inPane) };
}

const floored = (at: Point): Point => ({ x: Math.floor(at.x), y: Math.floor(at.y) });
const isOnImage = (desk: Desk, at: Point): boolean => {
  const { width, height } = desk.size.peek();
  return at.x >= 0 && at.y >= 0 && at.x < width && at.y < height;
};

interface Drag {
  /** By pointer; two of them pinch. */
  points: Map<number, Point>;
  from: Point;
  moved: boolean;
  cropFrom: Point | null;
}

export function Stage({ desk, canvasRef }: { desk: Desk; canvasRef: { current: HTMLCanvasElement | null } }) {
  const stage = useRef<HTMLDivElement>(null);
  const canvas = canvasRef;
  const drag = useRef<Drag | null>(null);
  const [missing, setMissing] = useState(false);
  const [lost, setLost] = useState(false);
  const [drawn, setDrawn] = useState<{ from: Point; to: Point } | null>(null);

  useEffect(() => {
    const element = canvas.current!;
    const developer = Developer.make(
      () => setLost(true),
      () => {
        setLost(false);
        drawNow(desk, element);
      },
    );
    if (!developer) return setMissing(true);
    desk.developer.value = developer;
    let frame = 0;
    const stopDrawing = effect(() => {
      piecesOf(desk);
      void isDark.value;
      void desk.stage.value;
      if (!frame)
        frame = requestAnimationFrame(() => {
          frame = 0;
          drawNow(desk, element);
        });
    });
    const sizes = new ResizeObserver(([entry]) => {
      if (!entry) return;
      const exact = entry.devicePixelContentBoxSize?.[0];
      const density = window.devicePixelRatio || 1;
      const width = Math.max(1, exact?.inlineSize ?? Math.round(entry.contentRect.width * density));
      const height = Math.max(1, exact?.blockSize ?? Math.round(entry.contentRect.height * density));
      // Setting the size empties the canvas, so it is drawn at once.
      element.width = width;
      element.height = height;
      desk.density.value = density;
      desk.stage.value = { width, height };
      drawNow(desk, element);
    });
    sizes.observe(element);
    return () => {
      stopDrawing();
      cancelAnimationFrame(frame);
      sizes.disconnect();
      desk.developer.value = null;
      developer.close();
    };
  }, [desk]);

  const placeOf = (event: MouseEvent): Point => {
    const corner = canvas.current!.getBoundingClientRect();
    const density = desk.density.peek();
    return { x: (event.clientX - corner.left) * density, y: (event.clientY - corner.top) * density };
  };

  useEffect(() => {
    const element = stage.current!;
    // Not passive, as it would be by a property: the page must not scroll meanwhile.
    const onWheel = (event: WheelEvent) => {
      const found = under(desk, placeOf(event));
      if (!found) return;
      event.preventDefault();
      const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 20 : 1;
      const view = desk.view.peek();
      const factor = Math.exp(-event.deltaY * lines * (event.ctrlKey ? 0.01 : 0.002));
      desk.setView(zoomedAt(view, found.pane.box, found.inPane, view.zoom * factor));
    };
    element.addEventListener("wheel", onWheel, { passive: false });
    return () => element.removeEventListener("wheel", onWheel);
  }, [desk]);

  function onPointerDown(event: PointerEvent): void {
    if (event.button !== 0 && event.button !== 1) return;
    if ((event.target as Element).closest(".compare-wipe")) return;
    stage.current!.setPointerCapture(event.pointerId);
    const at = placeOf(event);
    const points = new Map(drag.current?.points).set(event.pointerId, at);
    const found = under(desk, at);
    const crops = event.button === 0 && (desk.cropping.peek() || event.shiftKey) && points.size === 1;
    drag.current = { points, from: at, moved: points.size > 1, cropFrom: crops && found ? found.place : null };
  }

  function onPointerMove(event: PointerEvent): void {
    const at = placeOf(event);
    const held = drag.current;
    const before = held?.points.get(event.pointerId);
    const found = under(desk, at);
    desk.hovered.value = found && isOnImage(desk, found.place) ? floored(found.place) : null;
    if (!held || !before) return;
    if (Math.hypot(at.x - held.from.x, at.y - held.from.y) > kClickPixels) held.moved = true;
    if (!held.moved) return;
    if (held.cropFrom) {
      if (found) setDrawn({ from: held.cropFrom, to: found.place });
      return;
    }
    const others = [...held.points].filter(([id]) => id !== event.pointerId).map(([, point]) => point);
    held.points.set(event.pointerId, at);
    let view = panned(desk.view.peek(), desk.size.peek(), (at.x - before.x) / held.points.size, (at.y - before.y) / held.points.size);
    const other = others[0];
    if (other && found) {
      const apart = (point: Point) => Math.max(1, Math.hypot(point.x - other.x, point.y - other.y));
      const middle = { x: (at.x + other.x) / 2 - found.pane.box.x, y: (at.y + other.y) / 2 - found.pane.box.y };
      view = zoomedAt(view, found.pane.box, middle, (view.zoom * apart(at)) / apart(before));
    }
    desk.setView(view);
  }

  function onPointerUp(event: PointerEvent): void {
    const held = drag.current;
    if (!held) return;
    held.points.delete(event.pointerId);
    if (held.points.size > 0) return;
    drag.current = null;
    setDrawn(null);
    if (event.type === "pointercancel") return;
    const found = under(desk, placeOf(event));
    if (held.cropFrom && held.moved) {
      const crop = cropBetween(held.cropFrom, found?.place ?? held.cropFrom, desk.size.peek());
      const crops = desk.look.peek().crops;
      if (crop && crops.length < kMaxCrops) desk.change({ crops: [...crops, crop] });
      desk.cropping.value = false;
    } else if (!held.moved && event.button === 0 && found && isOnImage(desk, found.place)) {
      desk.change({ pixel: floored(found.place) });
    }
  }

  function onDoubleClick(event: MouseEvent): void {
    const found = under(desk, placeOf(event));
    if (!found) return;
    if (desk.look.peek().zoom === null) desk.setView(zoomedAt(desk.view.peek(), found.pane.box, found.inPane, Math.max(1, 2 * Math.round(desk.view.peek().zoom))));
    else desk.fit();
  }

  return (
    <div
      ref={stage}
      class={`compare-stage${desk.cropping.value ? " cropping" : ""}`}
      tabIndex={0}
      role="group"
      aria-label="Pictures. Arrow keys move them, + and − zoom, 1 to 9 choose the image, ? lists all keys."
      onPointerDown={onPointerDown}
      onPointerMove={onPointerMove}
      onPointerUp={onPointerUp}
      onPointerCancel={onPointerUp}
      onPointerLeave={() => (desk.hovered.value = null)}
      onDblClick={onDoubleClick}
    >
      <Canvas desk={desk} canvas={canvas} />
      {!missing && <Overlay desk={desk} drawn={drawn} />}
      {(missing || lost) && (
        <div class="compare-missing">
          <p class="notice failed" role="alert">
            {missing
              ? "This browser gives the page no WebGL2, by which images are compared here: they are light, not display colours, and the display's work is done on the graphics unit. Firefox, Chrome, Edge and Safari of the last years have it; it may be switched off in the settings (hardware acceleration), or by a driver that the browser does not trust."
              : "The graphics unit has been taken away from the page. The pictures come back when it does."}
          </p>
        </div>
      )}
    </div>
  );
}

/** Named by what it shows, for who cannot see it. */
function Canvas({ desk, canvas }: { desk: Desk; canvas: { current: HTMLCanvasElement | null } }) {
  const names = desk.panes.value.map(({ index }) => `${index + 1}, ${desk.sources.value.get(desk.part("images").value[index]!)?.title ?? ""}`);
  const error = desk.part("error").value;
  const label = `${error === "none" ? "" : `${error.replace("_", " ")} error of `}image ${names.join(" beside image ")}; layer ${desk.part("layer").value}`;
  return <canvas ref={canvas} role="img" aria-label={label} />;
}
