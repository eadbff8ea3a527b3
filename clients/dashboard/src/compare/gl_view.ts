// Pictures on a canvas by WebGL2: pixels go to textures as the daemon sends them, are developed once for each way to
// show them, and presented as often as the view changes.

import { colourMap, type MapName } from "./colour_maps";
import type { Crop } from "./crops";
import type { Paint } from "./paint";
import type { PixelImage } from "./pixels";
import { kChannel, kColours, kCurve, kDevelop, kPresent, kQuantity, kWholeCanvas } from "./shaders";
import { placed, type Box, type View } from "./view";

export interface Picture {
  image: PixelImage;
  /** What errors are against, of the same size. */
  reference: PixelImage | null;
  paint: Paint;
}

/** A picture in a pane of the canvas; only what lies in `clip` is drawn. Boxes from the upper left, device pixels. */
export interface Piece {
  picture: Picture;
  view: View;
  pane: Box;
  clip: Box;
}

interface Developed {
  texture: WebGLTexture;
  target: WebGLFramebuffer;
  width: number;
  height: number;
  of: PixelImage[];
  used: number;
}

interface Program {
  program: WebGLProgram;
  at: (name: string) => WebGLUniformLocation | null;
}

const kDevelopedBytes = 256 * 2 ** 20;

export class GlView {
  private develop!: Program;
  private present!: Program;
  private raw = new Map<PixelImage, WebGLTexture>();
  private maps = new Map<MapName, WebGLTexture>();
  private developed = new Map<string, Developed>();
  private numbers = new WeakMap<PixelImage, number>();
  private nextNumber = 1;
  private frame = 0;
  readonly greatestSide: number;

  /** Null where the browser has no WebGL2. */
  static on(canvas: HTMLCanvasElement): GlView | null {
    const gl = canvas.getContext("webgl2", { alpha: false, antialias: false, depth: false, stencil: false, powerPreference: "high-performance" });
    return gl && new GlView(gl, canvas);
  }

  private constructor(
    private readonly gl: WebGL2RenderingContext,
    private readonly canvas: HTMLCanvasElement,
  ) {
    this.greatestSide = gl.getParameter(gl.MAX_TEXTURE_SIZE) as number;
    this.begin();
  }

  /** Makes programs and forgets textures: at first, and after the browser has taken the context away and given it back. */
  begin(): void {
    const gl = this.gl;
    this.develop = this.compile(kDevelop);
    this.present = this.compile(kPresent);
    this.raw.clear();
    this.maps.clear();
    this.developed.clear();
    gl.enable(gl.SCISSOR_TEST);
    gl.disable(gl.DITHER);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
    gl.bindVertexArray(gl.createVertexArray());
  }

  get isLost(): boolean {
    return this.gl.isContextLost();
  }

  /** Why an image cannot be shown here; null where it can. */
  whyNot(image: PixelImage): string | null {
    const side = Math.max(image.width, image.height);
    return side > this.greatestSide ? `${image.width} × ${image.height} pixels; this device shows up to ${this.greatestSide} a side` : null;
  }

  /** Lets go of what belongs to images that are no longer held. */
  retain(images: Set<PixelImage>): void {
    for (const [image, texture] of this.raw)
      if (!images.has(image)) {
        this.gl.deleteTexture(texture);
        this.raw.delete(image);
      }
    for (const [key, one] of this.developed) if (one.of.some((image) => !images.has(image))) this.drop(key, one);
  }

  draw(background: [number, number, number], pieces: Piece[]): void {
    const gl = this.gl;
    ++this.frame;
    const { width, height } = this.canvas;
    const ready = pieces.map((piece) => ({ piece, box: placed(piece.view, piece.picture.image, piece.pane), picture: this.developedFor(piece) }));
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, width, height);
    gl.scissor(0, 0, width, height);
    gl.clearColor(background[0], background[1], background[2], 1);
    gl.clear(gl.COLOR_BUFFER_BIT);
    for (const { piece, box, picture } of ready) {
      const left = piece.pane.x + box.x;
      const top = piece.pane.y + box.y;
      const x0 = Math.max(0, left, piece.pane.x, piece.clip.x);
      const y0 = Math.max(0, top, piece.pane.y, piece.clip.y);
      // A device pixel belongs to the image where its middle does.
      const x1 = Math.min(width, Math.round(left + box.width), piece.pane.x + piece.pane.width, piece.clip.x + piece.clip.width);
      const y1 = Math.min(height, Math.round(top + box.height), piece.pane.y + piece.pane.height, piece.clip.y + piece.clip.height);
      if (x1 <= x0 || y1 <= y0) continue;
      gl.scissor(x0, height - y1, x1 - x0, y1 - y0);
      this.put(picture, left, top, height, Math.max(1, piece.view.zoom));
    }
    this.evict();
  }

  /** A part of a picture at a whole zoom, as RGBA rows from the top. */
  crop(picture: Picture, crop: Crop, zoom: number): ImageData {
    const gl = this.gl;
    const small = this.target(crop.width, crop.height);
    this.run(picture, small, { x: crop.x, y: crop.y }, 1, 1);
    const width = crop.width * zoom;
    const height = crop.height * zoom;
    const large = this.target(width, height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, large.target);
    gl.viewport(0, 0, width, height);
    gl.scissor(0, 0, width, height);
    this.put(small, 0, 0, 0, zoom);
    const data = new Uint8ClampedArray(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(data.buffer));
    for (const made of [small, large]) {
      gl.deleteFramebuffer(made.target);
      gl.deleteTexture(made.texture);
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return new ImageData(data, width, height);
  }

  private put(picture: { texture: WebGLTexture; width: number; height: number }, left: number, top: number, height: number, zoom: number): void {
    const gl = this.gl;
    gl.useProgram(this.present.program);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, picture.texture);
    gl.uniform1i(this.present.at("uPicture"), 0);
    gl.uniform2f(this.present.at("uPlace"), left, top);
    gl.uniform1f(this.present.at("uHeight"), height);
    gl.uniform1f(this.present.at("uPerPixel"), 1 / zoom);
    gl.uniform2i(this.present.at("uLast"), picture.width - 1, picture.height - 1);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  private developedFor({ picture, view, pane }: Piece): Developed {
    const { image, reference, paint } = picture;
    const box = placed(view, image, pane);
    const [width, height] = view.zoom >= 1 ? [image.width, image.height] : [box.width, box.height];
    const against = paint.quantity === "pixel" ? null : reference;
    const key = [this.numberOf(image), against ? this.numberOf(against) : 0, width, height, ...Object.values(paint)].join("|");
    let found = this.developed.get(key);
    if (!found) {
      found = { ...this.target(width, height), of: against ? [image, against] : [image], used: 0 };
      this.run(picture, found, { x: 0, y: 0 }, image.width / width, image.height / height);
      this.developed.set(key, found);
    }
    found.used = this.frame;
    return found;
  }

  private run({ image, reference, paint }: Picture, into: { target: WebGLFramebuffer; width: number; height: number }, origin: { x: number; y: number }, stepX: number, stepY: number): void {
    const gl = this.gl;
    const { program, at } = this.develop;
    // Uploads bind textures: all of them before any is bound to be drawn with.
    const own = this.rawTexture(image);
    const against = reference && paint.quantity !== "pixel" ? this.rawTexture(reference) : own;
    const map = this.mapTexture(paint.map);
    gl.useProgram(program);
    [own, against, map].forEach((texture, unit) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, texture);
    });
    gl.uniform1i(at("uImage"), 0);
    gl.uniform1i(at("uReference"), 1);
    gl.uniform1i(at("uMap"), 2);
    gl.uniform2i(at("uSize"), image.width, image.height);
    gl.uniform2i(at("uOrigin"), origin.x, origin.y);
    gl.uniform2f(at("uStep"), stepX, stepY);
    gl.uniform1i(at("uGrey"), image.channels === 1 ? 1 : 0);
    gl.uniform1i(at("uQuantity"), kQuantity[paint.quantity]);
    gl.uniform1i(at("uColours"), kColours[paint.colours]);
    gl.uniform1i(at("uCurve"), kCurve[paint.curve]);
    gl.uniform1i(at("uChannel"), kChannel[paint.channel]);
    gl.uniform1f(at("uScale"), paint.scale);
    gl.uniform1f(at("uLow"), paint.low);
    gl.uniform1f(at("uHigh"), paint.high);
    gl.uniform1f(at("uFloor"), paint.floor);
    const { rgba, mixed } = colourMap(paint.map);
    gl.uniform1i(at("uMapLast"), rgba.length / 4 - 1);
    gl.uniform1i(at("uMapMixed"), mixed ? 1 : 0);
    gl.bindFramebuffer(gl.FRAMEBUFFER, into.target);
    gl.viewport(0, 0, into.width, into.height);
    gl.scissor(0, 0, into.width, into.height);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  private numberOf(image: PixelImage): number {
    let number = this.numbers.get(image);
    if (number === undefined) this.numbers.set(image, (number = this.nextNumber++));
    return number;
  }

  private texture(): WebGLTexture {
    const gl = this.gl;
    const texture = gl.createTexture();
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, filter, gl.NEAREST);
    for (const wrap of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, wrap, gl.CLAMP_TO_EDGE);
    return texture;
  }

  private rawTexture(image: PixelImage): WebGLTexture {
    const gl = this.gl;
    let texture = this.raw.get(image);
    if (texture) return texture;
    texture = this.texture();
    const half = image.data instanceof Uint16Array;
    const form = image.channels === 1 ? gl.RED : gl.RGB;
    const kept = image.channels === 1 ? (half ? gl.R16F : gl.R32F) : half ? gl.RGB16F : gl.RGB32F;
    gl.texImage2D(gl.TEXTURE_2D, 0, kept, image.width, image.height, 0, form, half ? gl.HALF_FLOAT : gl.FLOAT, image.data);
    this.raw.set(image, texture);
    return texture;
  }

  private mapTexture(name: MapName): WebGLTexture {
    const gl = this.gl;
    let texture = this.maps.get(name);
    if (texture) return texture;
    texture = this.texture();
    const { rgba } = colourMap(name);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, rgba.length / 4, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, rgba);
    this.maps.set(name, texture);
    return texture;
  }

  private target(width: number, height: number): { texture: WebGLTexture; target: WebGLFramebuffer; width: number; height: number } {
    const gl = this.gl;
    const texture = this.texture();
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, width, height, 0, gl.RGBA, gl.UNSIGNED_BYTE, null);
    const target = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, target);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
    return { texture, target, width, height };
  }

  private drop(key: string, one: Developed): void {
    this.gl.deleteFramebuffer(one.target);
    this.gl.deleteTexture(one.texture);
    this.developed.delete(key);
  }

  /** Lets go of the pictures that were not shown for longest, beyond what may be held. */
  private evict(): void {
    let bytes = 0;
    for (const [key, one] of [...this.developed].sort(([, a], [, b]) => b.used - a.used)) {
      bytes += 4 * one.width * one.height;
      if (bytes > kDevelopedBytes && one.used !== this.frame) this.drop(key, one);
    }
  }

  private compile(fragment: string): Program {
    const gl = this.gl;
    const program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, kWholeCanvas], [gl.FRAGMENT_SHADER, fragment]] as const) {
      const shader = gl.createShader(kind)!;
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost()) throw new Error(`shader: ${gl.getShaderInfoLog(shader)}`);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) throw new Error(`shaders: ${gl.getProgramInfoLog(program)}`);
    const places = new Map<string, WebGLUniformLocation | null>();
    return {
      program,
      at: (name) => {
        let place = places.get(name);
        if (place === undefined) places.set(name, (place = gl.getUniformLocation(program, name)));
        return place;
      },
    };
  }
}
