// The picture below the replay is seen until the replay draws, and where it cannot, or is printed.
// The replay is unpacked when it is almost visible, so that the page opens fast.
const stage = document.getElementById("stage");
const frame = document.getElementById("replay");

async function unpack() {
  const packed = atob(document.getElementById("packed").textContent);
  const bytes = Uint8Array.from(packed, (letter) => letter.charCodeAt(0));
  const page = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  frame.addEventListener("load", () => stage.classList.add("playing"), { once: true });
  frame.srcdoc = await new Response(page).text();
}

function draws() {
  const canvas = document.createElement("canvas");
  return Boolean(canvas.getContext("webgl2") || canvas.getContext("webgl"));
}

const near = new IntersectionObserver((seen) => {
  if (seen.some((entry) => entry.isIntersecting)) {
    near.disconnect();
    if (draws()) {
      unpack();
    } else {
      document.getElementById("still").hidden = false;
    }
  }
}, { rootMargin: "200px" });
addEventListener("load", () => near.observe(stage));

// Scrolling and swiping over the stage scroll the page until the button is pressed.
document.getElementById("take").addEventListener("click", () => {
  stage.classList.add("taken");
  frame.focus();
});
