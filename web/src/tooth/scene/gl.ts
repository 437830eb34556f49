import type { Matrix } from "./vec";

// The little of WebGL that a tooth needs: programs, shapes, and how one is drawn over the other.

export type Gl = WebGL2RenderingContext;
export type Uniform = number | readonly number[] | Float32Array;

// Places of attributes, in every program.
export const kAttributes = { position: 0, normal: 1, tissue: 2, deviation: 3, along: 4, own: 5 } as const;
// The texture of what fills a section (cut_fill.ts).
export const kSliceUnit = 1;
export type AttributeName = keyof typeof kAttributes;

export interface Attribute {
  readonly data: Float32Array<ArrayBuffer> | Int8Array<ArrayBuffer> | Uint8Array<ArrayBuffer>;
  readonly size: number; // numbers for each vertex
  readonly normalized?: boolean; // whole numbers stand for −1 … 1
}

// A program of both shaders; what is wrong with one is told by the browser, when it is drawn with.
export class Program {
  private readonly program: WebGLProgram;
  private readonly places = new Map<string, WebGLUniformLocation | null>();

  constructor(
    private readonly gl: Gl,
    vertex: string,
    fragment: string,
    defines: readonly string[] = [],
  ) {
    const head = `#version 300 es\n${defines.map((name) => `#define ${name}\n`).join("")}precision highp float;\n`;
    this.program = gl.createProgram();
    for (const [kind, source] of [
      [gl.VERTEX_SHADER, vertex],
      [gl.FRAGMENT_SHADER, fragment],
    ] as const) {
      const shader = gl.createShader(kind)!;
      gl.shaderSource(shader, head + source);
      gl.compileShader(shader);
      gl.attachShader(this.program, shader);
      gl.deleteShader(shader); // with the program
    }
    for (const [name, place] of Object.entries(kAttributes)) gl.bindAttribLocation(this.program, place, name);
    gl.linkProgram(this.program);
    gl.useProgram(this.program);
    gl.uniform1i(gl.getUniformLocation(this.program, "slice"), kSliceUnit); // the other texture is unit 0
  }

  use(uniforms: Readonly<Record<string, Uniform>>): void {
    this.gl.useProgram(this.program);
    for (const [name, value] of Object.entries(uniforms)) this.set(name, value);
  }
  set(name: string, value: Uniform): void {
    const { gl } = this;
    if (!this.places.has(name)) this.places.set(name, gl.getUniformLocation(this.program, name));
    const place = this.places.get(name) ?? null;
    if (place === null) return;
    if (typeof value === "number") gl.uniform1f(place, value);
    else if (value.length === 16) gl.uniformMatrix4fv(place, false, value as Matrix);
    else if (value.length === 4) gl.uniform4fv(place, value);
    else gl.uniform3fv(place, value); // one, or an array of them: three rows are one
  }
  dispose(): void {
    this.gl.deleteProgram(this.program);
  }
}

// Vertices on the graphics card, and how they are joined.
export class Shape {
  private readonly array: WebGLVertexArrayObject;
  private readonly buffers: WebGLBuffer[] = [];
  private readonly count: number;
  private readonly indexType: number | undefined;

  // `mode`: TRIANGLES, LINES or LINE_STRIP. Without an index the vertices follow each other.
  constructor(
    private readonly gl: Gl,
    attributes: Partial<Record<AttributeName, Attribute | undefined>>,
    index: Uint16Array<ArrayBuffer> | Uint32Array<ArrayBuffer> | undefined,
    private readonly mode: number = gl.TRIANGLES,
  ) {
    this.array = gl.createVertexArray();
    gl.bindVertexArray(this.array);
    let vertices = 0;
    for (const [name, attribute] of Object.entries(attributes)) {
      if (attribute === undefined) continue;
      this.point(name as AttributeName, attribute);
      vertices = attribute.data.length / attribute.size;
    }
    if (index !== undefined) this.fill(gl.ELEMENT_ARRAY_BUFFER, index);
    gl.bindVertexArray(null);
    this.indexType =
      index === undefined ? undefined : index instanceof Uint16Array ? gl.UNSIGNED_SHORT : gl.UNSIGNED_INT;
    this.count = index?.length ?? vertices;
  }
  // One more of each vertex.
  add(name: AttributeName, attribute: Attribute): void {
    this.gl.bindVertexArray(this.array);
    this.point(name, attribute);
    this.gl.bindVertexArray(null);
  }
  private point(name: AttributeName, { data, size, normalized = false }: Attribute): void {
    const { gl } = this;
    const place = kAttributes[name];
    this.fill(gl.ARRAY_BUFFER, data);
    const type = data instanceof Float32Array ? gl.FLOAT : data instanceof Int8Array ? gl.BYTE : gl.UNSIGNED_BYTE;
    gl.vertexAttribPointer(place, size, type, normalized, 0, 0);
    gl.enableVertexAttribArray(place);
  }
  private fill(target: number, data: AllowSharedBufferSource): void {
    const buffer = this.gl.createBuffer();
    this.buffers.push(buffer);
    this.gl.bindBuffer(target, buffer);
    this.gl.bufferData(target, data, this.gl.STATIC_DRAW);
  }

  draw(): void {
    const { gl } = this;
    if (this.count === 0) return;
    gl.bindVertexArray(this.array);
    if (this.indexType === undefined) gl.drawArrays(this.mode, 0, this.count);
    else gl.drawElements(this.mode, this.count, this.indexType, 0);
  }
  dispose(): void {
    this.gl.deleteVertexArray(this.array);
    for (const buffer of this.buffers) this.gl.deleteBuffer(buffer);
  }
}

// How what is drawn next meets what is there.
export interface Over {
  readonly depth?: boolean; // is hidden by what lies before it
  readonly hides?: boolean; // hides what lies behind it
  readonly faces?: "front" | "back" | "both";
  readonly mixed?: boolean; // by its opacity
  readonly color?: boolean; // false: only the stencil is written
  readonly stencil?: Stencil | undefined;
}
export interface Stencil {
  readonly where: "always" | "equal"; // to `mark`
  readonly write: "keep" | "replace" | "increment" | "decrement"; // replace: by `mark`
  readonly mark: number;
}

export function drawOver(
  gl: Gl,
  { depth = true, hides = true, faces = "front", mixed = false, color = true, stencil }: Over,
): void {
  const turnOn = (what: number, on: boolean) => (on ? gl.enable(what) : gl.disable(what));
  turnOn(gl.DEPTH_TEST, depth);
  gl.depthMask(depth && hides);
  gl.depthFunc(gl.LEQUAL);
  turnOn(gl.CULL_FACE, faces !== "both");
  gl.cullFace(faces === "back" ? gl.FRONT : gl.BACK);
  turnOn(gl.BLEND, mixed);
  gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  gl.colorMask(color, color, color, color);
  turnOn(gl.STENCIL_TEST, stencil !== undefined);
  if (stencil === undefined) return;
  const write = { keep: gl.KEEP, replace: gl.REPLACE, increment: gl.INCR_WRAP, decrement: gl.DECR_WRAP }[stencil.write];
  gl.stencilFunc(stencil.where === "equal" ? gl.EQUAL : gl.ALWAYS, stencil.mark, 255);
  gl.stencilOp(gl.KEEP, gl.KEEP, write);
}

export function beginPicture(gl: Gl): void {
  gl.depthMask(true);
  gl.colorMask(true, true, true, true);
  gl.clearColor(0, 0, 0, 0);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT | gl.STENCIL_BUFFER_BIT);
}
