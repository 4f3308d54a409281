export function element<T extends HTMLElement = HTMLElement>(id: string): T {
    return document.getElementById(id) as T;
}

/// The only maker of elements. Text is text, whatever it holds.
export function make<K extends keyof HTMLElementTagNameMap>(tag: K, text = "", name = ""): HTMLElementTagNameMap[K] {
    const made = document.createElement(tag);
    made.textContent = text;
    made.className = name;
    return made;
}

export function set_text(id: string, text: string): void {
    const found = element(id);
    if (found.textContent !== text) {
        found.textContent = text;
    }
}

export const grouped = (count: number) => count.toLocaleString("en-US");

/// With six digits that matter.
export function measure(value: number, unit = ""): string {
    return Number.isFinite(value) ? String(Number(value.toPrecision(6))) + unit : "not known";
}

export function counted(count: number, noun: string): string {
    return `${grouped(count)} ${noun}${count === 1 ? "" : "s"}`;
}

const sizes = new WeakMap<HTMLCanvasElement, [number, number]>();
const observer = new ResizeObserver((entries) => {
    for (const entry of entries) {
        sizes.set(entry.target as HTMLCanvasElement, [entry.contentRect.width, entry.contentRect.height]);
    }
    resized();
});
let resized = () => {};

export function watch_sizes(then: () => void, ...canvases: HTMLCanvasElement[]): void {
    resized = then;
    canvases.forEach((canvas) => observer.observe(canvas));
}

/// Gives the canvas the pixels that it takes on the screen; its size in CSS pixels, and pixels in one of them.
export function fit_canvas(canvas: HTMLCanvasElement): [number, number, number] {
    const [width, height] = sizes.get(canvas) ?? [canvas.clientWidth, canvas.clientHeight];
    const ratio = devicePixelRatio || 1;
    const [w, h] = [Math.max(1, Math.round(width * ratio)), Math.max(1, Math.round(height * ratio))];
    if (canvas.width !== w || canvas.height !== h) {
        canvas.width = w;
        canvas.height = h;
    }
    return [width, height, ratio];
}

let colours = new Map<string, string>();
/// A custom property of page.css.
export function colour(name: string): string {
    let value = colours.get(name);
    if (value === undefined) {
        value = getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
        colours.set(name, value);
    }
    return value;
}
export function forget_colours(): void {
    colours = new Map();
}

export function save(name: string, bytes: BlobPart, type: string): void {
    const link = make("a");
    link.href = URL.createObjectURL(new Blob([bytes], { type }));
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
