// The mesh below the plane, a breath of what is above, the layer as its cap, and the faults that the check found, in plain WebGL2. The cap is the layer as it is
// filled in 2D, so that it is right for open meshes and for every fill rule, too.
import { colour, fit_canvas } from "./dom";
import { fill_layer } from "./layer";
import { centre, plane_of, state } from "./state";

type Vector = [number, number, number];
const cap_pixels = 1024;

const vertex = `#version 300 es
in vec3 place; uniform mat4 view; uniform float size; uniform vec2 half_box; uniform float cap; out vec3 at; out vec2 uv;
void main() {
    at = place; uv = place.xy / half_box * 0.5 + 0.5;
    gl_Position = view * vec4(place, 1.0); gl_PointSize = size;
}`;
const faces = `#version 300 es
precision highp float; in vec3 at; uniform vec3 outside, inside, towards; uniform float plane, bottom, step, ghost; out vec4 colour;
void main() {
    if ((at.z > plane) != (ghost > 0.0)) discard;
    vec3 normal = normalize(cross(dFdx(at), dFdy(at)));
    float light = 0.4 + 0.6 * abs(dot(normal, towards)), layer = (at.z - bottom) / max(step, 1e-9), wide = fwidth(layer);
    if (step > 0.0 && wide < 0.4) light *= 1.0 - 0.22 * smoothstep(0.5 - wide, 0.5, abs(fract(layer) - 0.5));
    colour = vec4((gl_FrontFacing ? outside : inside) * light, ghost > 0.0 ? ghost : 1.0);
}`;
const plain = `#version 300 es
precision highp float; in vec2 uv; uniform sampler2D layer; uniform vec3 outside; uniform float cap; out vec4 colour;
void main() {
    colour = cap > 0.5 ? texture(layer, uv) : vec4(outside, 1.0);
    if (colour.a < 0.3) discard;
    colour.rgb /= colour.a; colour.a = 1.0;
}`;

export class Stack {
    failed = "";
    private yaw = 0.6;
    private pitch = 0.5;
    private zoom = 1;
    private gl: WebGL2RenderingContext | null = null;
    private programs: WebGLProgram[] = [];
    private buffers = new Map<string, { buffer: WebGLBuffer; of: unknown; count: number }>();
    private readonly cap = document.createElement("canvas");
    private capped: unknown = null;

    constructor(private readonly canvas: HTMLCanvasElement) {
        canvas.addEventListener("webglcontextlost", (event) => {
            event.preventDefault();
            this.gl = null;
        });
        canvas.addEventListener("webglcontextrestored", () => this.prepare());
        this.prepare();
    }

    turn(dx: number, dy: number): void {
        this.yaw -= dx * 0.01;
        this.pitch = Math.max(-1.57, Math.min(1.57, this.pitch + dy * 0.01));
    }

    magnify(factor: number): void {
        this.zoom = Math.max(0.2, Math.min(50, this.zoom * factor));
    }

    home(): void {
        [this.yaw, this.pitch, this.zoom] = [0.6, 0.5, 1];
    }

    forget_cap(): void {
        this.capped = null;
    }

    /// To the right, upwards, and towards the eye.
    private axes(): [Vector, Vector, Vector] {
        const [cy, sy, cp, sp] = [Math.cos(this.yaw), Math.sin(this.yaw), Math.cos(this.pitch), Math.sin(this.pitch)];
        return [[cy, sy, 0], [-sp * sy, sp * cy, cp], [cp * sy, -cp * cy, sp]];
    }

    private radius(): number {
        const { min, max } = state.mesh!;
        return Math.max(Math.hypot(max[0] - min[0], max[1] - min[1], max[2] - min[2]) / 2, 1e-6);
    }

    /// Half of the canvas's width and height in mm: the mesh fits, however it is turned.
    private reach(): [number, number] {
        const { clientWidth: width, clientHeight: height } = this.canvas, { min, max } = state.mesh!;
        const round = Math.hypot(max[0] - min[0], max[1] - min[1]) / 2, tall = (max[2] - min[2]) / 2;
        const high = Math.max(round * Math.abs(Math.sin(this.pitch)) + tall * Math.cos(this.pitch), (round * height) / width, 1e-6);
        const upwards = (1.08 * high) / this.zoom;
        return [(upwards * width) / height, upwards];
    }

    private prepare(): void {
        const gl = (this.gl = this.canvas.getContext("webgl2", { antialias: true, alpha: false }));
        if (gl === null) {
            this.failed = "No 3D view: this browser has no WebGL2.";
            return;
        }
        this.buffers.clear();
        this.capped = null;
        this.programs = [faces, plain].map((fragment) => {
            const program = gl.createProgram();
            for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]] as const) {
                const shader = gl.createShader(kind)!;
                gl.shaderSource(shader, text);
                gl.compileShader(shader);
                gl.attachShader(program, shader);
            }
            gl.bindAttribLocation(program, 0, "place");
            gl.linkProgram(program);
            if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
                this.failed = `No 3D view: ${gl.getProgramInfoLog(program)}`;
            }
            return program;
        });
        this.cap.width = this.cap.height = cap_pixels;
        gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
        gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
        gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
        gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
        gl.enable(gl.DEPTH_TEST);
        gl.depthFunc(gl.LEQUAL);
        gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    }

    /// Draws vertices, which are sent again only where `of` is another than before.
    private draw(name: string, of: unknown, data: () => Float32Array, mode: number): void {
        const gl = this.gl!;
        let held = this.buffers.get(name);
        if (held === undefined) {
            this.buffers.set(name, (held = { buffer: gl.createBuffer(), of: undefined, count: 0 }));
        }
        gl.bindBuffer(gl.ARRAY_BUFFER, held.buffer);
        if (held.of !== of) {
            const numbers = data();
            gl.bufferData(gl.ARRAY_BUFFER, numbers, gl.STATIC_DRAW);
            [held.of, held.count] = [of, numbers.length / 3];
        }
        gl.enableVertexAttribArray(0);
        gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
        gl.drawArrays(mode, 0, held.count);
    }

    private half_box(): [number, number] {
        const { min, max } = state.mesh!;
        return [Math.max((max[0] - min[0]) / 2, 1e-6), Math.max((max[1] - min[1]) / 2, 1e-6)];
    }

    private fill_cap(): void {
        const gl = this.gl!, context = this.cap.getContext("2d")!, [hx, hy] = this.half_box();
        context.setTransform(1, 0, 0, 1, 0, 0);
        context.clearRect(0, 0, cap_pixels, cap_pixels);
        context.setTransform(cap_pixels / 2 / hx, 0, 0, cap_pixels / 2 / hy, cap_pixels / 2, cap_pixels / 2);
        fill_layer(context);
        gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, true);
        gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, this.cap);
        this.capped = state.layer;
    }

    private use(program: WebGLProgram, view: Float32Array, numbers: Record<string, number | number[]>): void {
        const gl = this.gl!;
        gl.useProgram(program);
        gl.uniformMatrix4fv(gl.getUniformLocation(program, "view"), false, view);
        for (const [name, value] of Object.entries(numbers)) {
            const at = gl.getUniformLocation(program, name);
            typeof value === "number" ? gl.uniform1f(at, value) : value.length === 2 ? gl.uniform2fv(at, value) : gl.uniform3fv(at, value);
        }
    }

    render(): void {
        const gl = this.gl, [width, height] = fit_canvas(this.canvas);
        if (gl === null || this.failed !== "" || width === 0 || height === 0) {
            return;
        }
        gl.viewport(0, 0, this.canvas.width, this.canvas.height);
        const ground = rgb("ground");
        gl.clearColor(ground[0]!, ground[1]!, ground[2]!, 1);
        gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
        if (state.mesh === null || state.layer === null || state.triangles === null) {
            return;
        }
        const [right, up, towards] = this.axes(), [across, upwards] = this.reach(), deep = 2 * this.radius();
        const view = new Float32Array(16);
        for (const axis of [0, 1, 2] as const) {
            view.set([right[axis] / across, up[axis] / upwards, -towards[axis] / deep, 0], 4 * axis);
        }
        view[15] = 1;
        const middle = centre()[2], plane = plane_of(state.layer.index) - middle, [hx, hy] = this.half_box();
        const step = state.plan.cusp > 0 ? 0 : state.plan.height;
        const look = { outside: rgb("outside"), inside: rgb("inside"), towards, plane, bottom: state.mesh.min[2] - middle, step, half_box: [hx, hy], size: 1 };
        this.use(this.programs[0]!, view, { ...look, ghost: 0 });
        this.draw("mesh", state.triangles, () => state.triangles!, gl.TRIANGLES);
        this.capped !== state.layer && this.fill_cap();
        this.use(this.programs[1]!, view, { half_box: [hx, hy], cap: 1, size: 1 });
        const corners = [[-hx, -hy], [hx, -hy], [-hx, hy], [hx, hy]].flatMap(([x, y]) => [x!, y!, plane]);
        this.draw("cap", plane, () => new Float32Array(corners), gl.TRIANGLE_STRIP);
        this.use(this.programs[0]!, view, { ...look, inside: look.outside, ghost: 0.08 });  // what is above, as a breath
        gl.enable(gl.BLEND);
        gl.depthMask(false);
        this.draw("mesh", state.triangles, () => state.triangles!, gl.TRIANGLES);
        gl.depthMask(true);
        gl.disable(gl.BLEND);
        this.draw_faults(view, [hx, hy]);
    }

    private draw_faults(view: Float32Array, half_box: number[]): void {
        const gl = this.gl!, checked = state.checked;
        if (checked !== null) {
            gl.disable(gl.DEPTH_TEST);
            this.use(this.programs[1]!, view, { half_box, cap: 0, size: 6 * devicePixelRatio, outside: rgb("fault") });
            this.draw("lines", checked, () => checked.lines, gl.LINES);
            this.draw("points", checked, () => checked.points, gl.POINTS);
            gl.enable(gl.DEPTH_TEST);
        }
    }
}

function rgb(name: string): number[] {
    const digits = colour(name).slice(1);
    return [0, 2, 4].map((at) => parseInt(digits.slice(at, at + 2), 16) / 255);
}
