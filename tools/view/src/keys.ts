// The keyboard. The dialog behind `?` is made of this list, too.
import { element, make } from "./dom";

export interface Key {
    keys: string[];
    says: string;
    act(key: string): void;
}

export function begin_keys(list: Key[]): void {
    const table = element("keys");
    for (const { keys, says } of list) {
        const row = make("tr"), cell = make("td");
        cell.append(...keys.map((key) => make("kbd", key === " " ? "Space" : key)));
        row.append(cell, make("td", says));
        table.append(row);
    }
    addEventListener("keydown", (event) => {
        const { target, key } = event;
        const typing = target instanceof HTMLInputElement || target instanceof HTMLSelectElement;
        const pressing = target instanceof HTMLButtonElement && (key === "Enter" || key === " ");
        if (event.ctrlKey || event.metaKey || event.altKey || pressing || document.querySelector("dialog[open]") !== null) {
            return;
        }
        if (typing && key !== "Escape") {
            return;
        }
        const name = event.shiftKey && key === "Tab" ? "Shift+Tab" : key.length === 1 ? key.toUpperCase() : key;
        const found = list.find(({ keys }) => keys.includes(name));
        if (found !== undefined) {
            event.preventDefault();
            found.act(name);
        }
    });
}
