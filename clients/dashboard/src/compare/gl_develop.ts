// Pictures of pixels by WebGL2: values go to textures as the daemon sends them, and are developed to display colours once
// for an image and a way to show it.

import { colourMap, type MapName } from "./colour_maps";
import type { Paint } from "./paint";
import type { PixelImage } from "./pixels";
import { kChannel, kColours, kCurve, kDevelop, kQuantity, kWholeCanvas } from "./shaders";
import type { Box, Point, Size } from "./view";

export interface Picture {
  image: PixelImage;
  /** What errors are against, of the same size. */
  reference: PixelImage | null;
  paint: Paint;
}

interface Developed {
  canvas: HTMLCanvasElement;
  of: PixelImage[];
  used: number;
}

const kDevelopedBytes = 256 * 2 ** 20;
/** Sides of what is drawn at once: browsers give less than was asked for beyond some size. */
const kTile = 2048;

export class Developer {
  private program!: WebGLProgram;
  private places = new Map<string, WebGLUniformLocation | null>();
  private raw = new Map<PixelImage, WebGLTexture>();
  private maps = new Map<MapName, WebGLTexture>();
  private developed = new Map<string, Developed>();
  private numbers = new WeakMap<PixelImage, number>();
  private nextNumber = 1;
  private round = 0;
  readonly greatestSide: number;

  /** Null where the browser has no WebGL2. `onBack`: it has given back what it had taken, and all can be drawn again. */
  static make(onLost: () => void, onBack: () => void): Developer | null {
    const canvas = document.createElement("canvas");
    const gl = canvas.getContext("webgl2", { alpha: false, antialias: false, depth: false, stencil: false, powerPreference: "high-performance" });
    if (!gl) return null;
    const developer = new Developer(gl, canvas);
    canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault(); // or it would not come back
      onLost();
    });
    canvas.addEventListener("webglcontextrestored", () => {
      developer.begin();
      onBack();
    });
    return developer;
  }

  private constructor(
    private readonly gl: WebGL2RenderingContext,
    private readonly canvas: HTMLCanvasElement,
  ) {
    this.greatestSide = gl.getParameter(gl.MAX_TEXTURE_SIZE) as number;
    this.begin();
  }

  private begin(): void {
    const gl = this.gl;
    this.raw.clear();
    this.maps.clear();
    this.places.clear();
    this.program = this.compile();
    gl.disable(gl.DITHER);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.bindVertexArray(gl.createVertexArray());
  }

  /** Gives the graphics unit back what it holds for this page; browsers allow a page but a few of these. */
  close(): void {
    this.developed.clear();
    this.gl.getExtension("WEBGL_lose_context")?.loseContext();
  }

  /** Why an image cannot be shown here; null where it can. */
  whyNot(image: Size): string | null {
    const side = Math.max(image.width, image.height);
    return side > this.greatestSide ? `${image.width} × ${image.height} pixels; this graphics unit takes up to ${this.greatestSide} a side` : null;
  }

  /** Lets go of what belongs to images that are no longer held. */
  retain(images: ReadonlySet<PixelImage>): void {
    for (const [image, texture] of this.raw)
      if (!images.has(image)) {
        this.gl.deleteTexture(texture);
        this.raw.delete(image);
      }
    for (const [key, one] of this.developed) if (one.of.some((image) => !images.has(image))) this.developed.delete(key);
  }

  /** The next picture of the view begins: what is asked for until the next call is kept together. */
  beginRound(): void {
    ++this.round;
    let bytes = 0;
    for (const [key, one] of [...this.developed].sort(([, a], [, b]) => b.used - a.used)) {
      bytes += 4 * one.canvas.width * one.canvas.height;
      if (bytes > kDevelopedBytes && one.used < this.round - 1) this.developed.delete(key);
    }
  }

  /** The whole picture in display colours, averaged where `size` is smaller than it; null while the context is lost. */
  picture(picture: Picture, size: Size): HTMLCanvasElement | null {
    const { image, reference, paint } = picture;
    const against = paint.quantity === "pixel" ? null : reference;
    const key = [this.numberOf(image), against ? this.numberOf(against) : 0, size.width, size.height, ...Object.values(paint)].join("|");
    let found = this.developed.get(key);
    if (!found) {
      const canvas = this.part(picture, { x: 0, y: 0, width: image.width, height: image.height }, size);
      if (!canvas) return null;
      found = { canvas, of: against ? [image, against] : [image], used: 0 };
      this.developed.set(key, found);
    }
    found.used = this.round;
    return found.canvas;
  }

  /** A part of a picture, in as many pixels as `size` says. */
  part(picture: Picture, part: Box, size: Size): HTMLCanvasElement | null {
    if (this.gl.isContextLost()) return null;
    const canvas = document.createElement("canvas");
    canvas.width = size.width;
    canvas.height = size.height;
    const context = canvas.getContext("2d", { alpha: false })!;
    this.prepare(picture, part, { x: part.width / size.width, y: part.height / size.height });
    for (let y = 0; y < size.height; y += kTile)
      for (let x = 0; x < size.width; x += kTile) {
        const width = Math.min(kTile, size.width - x);
        const height = Math.min(kTile, size.height - y);
        this.drawTile({ x, y, width, height });
        context.drawImage(this.canvas, x, y);
      }
    return canvas;
  }

  private at(name: string): WebGLUniformLocation | null {
    let place = this.places.get(name);
    if (place === undefined) this.places.set(name, (place = this.gl.getUniformLocation(this.program, name)));
    return place;
  }

  private prepare({ image, reference, paint }: Picture, part: Box, step: Point): void {
    const gl = this.gl;
    // Uploads bind textures: all of them before any is bound to be drawn with.
    const own = this.rawTexture(image);
    const against = reference && paint.quantity !== "pixel" ? this.rawTexture(reference) : own;
    const map = this.mapTexture(paint.map);
    [own, against, map].forEach((texture, unit) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, texture);
    });
    gl.useProgram(this.program);
    gl.uniform1i(this.at("uImage"), 0);
    gl.uniform1i(this.at("uReference"), 1);
    gl.uniform1i(this.at("uMap"), 2);
    gl.uniform2i(this.at("uSize"), part.x + part.width, part.y + part.height);
    gl.uniform2i(this.at("uOrigin"), part.x, part.y);
    gl.uniform2f(this.at("uStep"), step.x, step.y);
    gl.uniform1i(this.at("uGrey"), image.channels === 1 ? 1 : 0);
    gl.uniform1i(this.at("uQuantity"), kQuantity[paint.quantity]);
    gl.uniform1i(this.at("uColours"), kColours[paint.colours]);
    gl.uniform1i(this.at("uCurve"), kCurve[paint.curve]);
    gl.uniform1i(this.at("uChannel"), kChannel[paint.channel]);
    gl.uniform1f(this.at("uScale"), paint.scale);
    gl.uniform1f(this.at("uLow"), paint.low);
    gl.uniform1f(this.at("uHigh"), paint.high);
    gl.uniform1f(this.at("uFloor"), paint.floor);
    const { rgba, mixed } = colourMap(paint.map);
    gl.uniform1i(this.at("uMapLast"), rgba.length / 4 - 1);
    gl.uniform1i(this.at("uMapMixed"), mixed ? 1 : 0);
  }

  private drawTile({ x, y, width, height }: Box): void {
    const gl = this.gl;
    // Setting a size empties the canvas even where it is the same.
    if (this.canvas.width !== width) this.canvas.width = width;
    if (this.canvas.height !== height) this.canvas.height = height;
    gl.viewport(0, 0, width, height);
    gl.uniform2f(this.at("uTile"), x, y);
    gl.uniform1f(this.at("uHeight"), height);
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

  private compile(): WebGLProgram {
    const gl = this.gl;
    const program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, kWholeCanvas], [gl.FRAGMENT_SHADER, kDevelop]] as const) {
      const shader = gl.createShader(kind)!;
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost()) throw new Error(`shader: ${gl.getShaderInfoLog(shader)}`);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) throw new Error(`shaders: ${gl.getProgramInfoLog(program)}`);
    return program;
  }
}
