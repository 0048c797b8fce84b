// The replay is unpacked when it is almost visible, so that the page opens fast.
const stage = document.getElementById("stage");
const frame = document.getElementById("replay");

async function unpack() {
  const packed = atob(document.getElementById("packed").textContent);
  const bytes = Uint8Array.from(packed, (letter) => letter.charCodeAt(0));
  const page = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  frame.srcdoc = await new Response(page).text();
}

const near = new IntersectionObserver((seen) => {
  if (seen.some((entry) => entry.isIntersecting)) {
    near.disconnect();
    unpack();
  }
}, { rootMargin: "200px" });
addEventListener("load", () => near.observe(stage));

// Scrolling and swiping over the stage scroll the page until the button is pressed.
document.getElementById("take").addEventListener("click", () => {
  stage.classList.add("taken");
  frame.focus();
});
